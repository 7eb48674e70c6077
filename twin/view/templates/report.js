"use strict";
// of an A4 or letter page, in the pixels of plots that are printed at four fifths
const PRINTED_PX = 830, PRINTED_HALF_PX = 395;
const plots = [...document.querySelectorAll(".plot")];
const settings = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
let following = false;

async function unpack(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

// A plot is drawn when it is first seen: a folded one has no width before.
async function draw(plot) {
  if (plot.dataset.drawn) return;
  plot.dataset.drawn = "yes";
  const figure = JSON.parse(plot.nextElementSibling.textContent);
  await Plotly.newPlot(plot, figure.data, figure.layout, settings);
  if (plot.dataset.link) plot.on("plotly_relayout", change => follow(plot, change));
  if (plot.dataset.pick) plot.on("plotly_click", click => choose(plot, click.points));
}

// Clicked poles are chosen, or given back; the command below takes them.
function choose(plot, clicked) {
  const pole = clicked.find(p => p.data.mode === "markers");
  if (!pole) return;
  const f = Number(pole.x.toPrecision(7)), chosen = new Set(plot.chosen || []);
  if (!chosen.delete(f)) chosen.add(f);
  plot.chosen = [...chosen].sort((a, b) => a - b);
  plot.modes = plot.modes || [...(plot.layout.shapes || [])];
  const rings = plot.chosen.map(x => ({ type: "line", xref: "x", yref: "paper", x0: x, x1: x, y0: 0,
    y1: 1, line: { color: "#1d2733", width: 1.5 } }));
  Plotly.relayout(plot, { shapes: [...plot.modes, ...rings] });
  const shown = plot.closest("figure").querySelector(".picked");
  shown.hidden = !plot.chosen.length;
  const command = plot.dataset.pick.replace(/ --(pick|poles[= ]\S+)/g, "");
  shown.firstElementChild.textContent = `${command} --poles ${plot.chosen.join(",")}`;
}

function follow(plot, change) {
  if (following || !Object.keys(change).some(key => key.startsWith("xaxis."))) return;
  following = true;
  const axis = plot.layout.xaxis;
  const same = plots.filter(p => p !== plot && p.dataset.link === plot.dataset.link && p.layout);
  const range = axis.autorange ? { "xaxis.autorange": true } : { "xaxis.range": [...axis.range] };
  Promise.all(same.map(p => Plotly.relayout(p, range))).finally(() => { following = false; });
}

for (const button of document.querySelectorAll(".keys button")) {
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(shown));
    const plot = button.closest("figure").querySelector(".plot");
    const mine = plot.data.flatMap((trace, i) => trace.name === button.dataset.name ? [i] : []);
    if (mine.length) Plotly.restyle(plot, { visible: shown }, mine);
  });
}

function visible(plot) { return plot.offsetParent !== null; }
function drawVisible() { return Promise.all(plots.filter(visible).map(draw)); }
for (const fold of document.querySelectorAll("details")) fold.addEventListener("toggle", drawVisible);

let folded = [];
window.addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  for (const fold of folded) fold.open = true;
  for (const plot of plots) {
    draw(plot);
    const half = plot.closest("figure").classList.contains("half");
    Plotly.relayout(plot, { width: half ? PRINTED_HALF_PX : PRINTED_PX });
  }
});
window.addEventListener("afterprint", () => {
  for (const fold of folded) fold.open = false;
  for (const plot of plots) if (plot.layout) Plotly.relayout(plot, { width: null, autosize: true });
});

unpack(document.getElementById("library").textContent.trim()).then(code => {
  const script = document.createElement("script");
  script.textContent = code;
  document.head.append(script);
  return drawVisible();
}).then(() => { document.body.dataset.ready = "yes"; });
