"""Reports as one HTML file each: text, tables and plots that can be zoomed, no network."""
