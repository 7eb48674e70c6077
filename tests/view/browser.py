"""A headless Chromium, driven by its own command line: no driver has to be installed."""

import json
import re
import shutil
import subprocess

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
SECONDS = 60

DRAG = """
<script>
addEventListener("load", () => {
  const found = { errors: [] };
  addEventListener("error", event => found.errors.push(String(event.message)));
  addEventListener("unhandledrejection", event => found.errors.push(String(event.reason)));
  const wait = setInterval(async () => {
    if (document.body.dataset.ready !== "yes") return;
    clearInterval(wait);
    for (const fold of document.querySelectorAll("details")) fold.open = true;
    await new Promise(done => setTimeout(done, 1500));
    const all = [...document.querySelectorAll(".plot")];
    found.drawn = all.filter(p => p.querySelector("svg.main-svg")).length;
    found.plots = all.length;
    const size = thing => thing.getBoundingClientRect();
    found.outside = all.flatMap(p => [...p.querySelectorAll("svg.main-svg text")].filter(t => {
      const own = size(t), room = size(p);
      return own.width && (own.left < room.left - 1 || own.right > room.right + 1 ||
        own.top < room.top - 1 || own.bottom > room.bottom + 1);
    }).map(t => t.textContent));
    found.covered = all.flatMap(p => {
      const bar = size(p.querySelector(".modebar"));
      return [...p.querySelectorAll(".annotation text, .gtitle")].filter(t => {
        const own = size(t);
        return own.width && own.right > bar.left && own.bottom > bar.top && own.top < bar.bottom;
      }).map(t => t.textContent);
    });
    const plot = all.find(p => p.dataset.link) || all[0];
    const box = plot.querySelector(".nsewdrag").getBoundingClientRect();
    const at = (type, share) => new MouseEvent(type, {
      bubbles: true, cancelable: true, view: window, buttons: 1,
      clientX: box.left + share * box.width, clientY: box.top + box.height / 2 });
    const link = plot.dataset.link;
    const others = all.filter(p => p !== plot && link && p.dataset.link === link);
    found.before = plot.layout.xaxis.range.map(Number);
    const target = plot.querySelector(".nsewdrag");
    target.dispatchEvent(at("mousedown", 0.3));
    for (const share of [0.4, 0.5, 0.6]) document.dispatchEvent(at("mousemove", share));
    document.dispatchEvent(at("mouseup", 0.6));
    await new Promise(done => setTimeout(done, 1000));
    found.after = plot.layout.xaxis.range.map(Number);
    found.linked = others.map(p => p.layout.xaxis.range.map(Number));
    dispatchEvent(new Event("beforeprint"));
    await new Promise(done => setTimeout(done, 1000));
    found.printed = all.map(p => p.querySelector("svg.main-svg").getBoundingClientRect().width);
    dispatchEvent(new Event("afterprint"));
    await new Promise(done => setTimeout(done, 500));
    const button = document.querySelector(".keys button");
    button.click();
    found.pressed = button.getAttribute("aria-pressed");
    found.width = document.documentElement.scrollWidth;
    const picking = all.find(p => p.dataset.pick);
    if (picking) {
      const first = picking.data.find(t => t.mode === "markers");
      const at = x => ({ points: [{ data: first, x }] });
      for (const x of [7.25, 2.5, 9.0, 9.0]) picking.emit("plotly_click", at(x));
      await new Promise(done => setTimeout(done, 300));
      found.picked = picking.closest("figure").querySelector(".picked code").textContent;
      found.lines = picking.layout.shapes.length;
    }
    const out = document.createElement("pre");
    out.id = "found";
    out.textContent = JSON.stringify(found);
    document.body.append(out);
  }, 100);
});
</script>
"""


def chromium():
    """Return the path of a browser, or skip the test."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(f"no browser is installed; one of {', '.join(NAMES)} is needed")
    return found


FRAME = """
<body style="margin:0"><iframe width="%d" height="2000" style="border:0"></iframe><script>
const frame = document.querySelector("iframe");
frame.srcdoc = %s;
const wait = setInterval(() => {
  const found = frame.contentDocument?.getElementById("found");
  if (!found) return;
  clearInterval(wait);
  document.body.append(found.cloneNode(true));
}, 200);
</script></body>
"""


def opened(html, folder, width=1200):
    """Open a page, draw all its plots, zoom one by dragging; return what was seen.

    No window is narrower than 500 pixels: the page stands in a frame of the width.
    """
    page = folder / "dragged.html"
    inside = json.dumps(html.replace("<head>", "<head>" + DRAG, 1)).replace("<", "\\u003c")
    page.write_text(FRAME % (width, inside), encoding="utf-8")
    done = subprocess.run(
        [
            chromium(), "--headless=new", "--no-sandbox", "--disable-gpu", "--dump-dom",
            "--enable-logging=stderr", "--virtual-time-budget=60000",
            f"--window-size={max(width, 500)},2000", f"--user-data-dir={folder / 'profile'}",
            page.as_uri(),
        ],
        capture_output=True, text=True, timeout=SECONDS, check=False,
    )  # fmt: skip
    match = re.search(r'<pre id="found">(.*?)</pre>', done.stdout, re.S)
    assert match, done.stderr[-2000:]
    seen = json.loads(match[1].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
    seen["console"] = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return seen


def printed(html, folder):
    """Return how many pages a report has in print, and the size of the first [pt]."""
    page, paper = folder / "printed.html", folder / "printed.pdf"
    page.write_text(html, encoding="utf-8")
    subprocess.run(
        [
            chromium(), "--headless=new", "--no-sandbox", "--disable-gpu",
            f"--print-to-pdf={paper}", "--no-pdf-header-footer", "--virtual-time-budget=60000",
            f"--user-data-dir={folder / 'profile'}", page.as_uri(),
        ],
        capture_output=True, timeout=SECONDS, check=True,
    )  # fmt: skip
    content = paper.read_bytes()
    size = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", content)
    return len(re.findall(rb"/Type /Page\b", content)), tuple(float(x) for x in size.groups())
