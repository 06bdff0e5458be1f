// Draws the figures of <script id="figures">: plotly's data and layout, with colours by name from CSS.
(() => {
  "use strict";
  const specs = JSON.parse(document.getElementById("figures").textContent);
  const CONFIG = { responsive: true, displaylogo: false, scrollZoom: false,
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"] };
  const MARGIN = { l: 74, r: 16, t: 70, b: 56 };

  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  // "@observer" and "@observer59" (two digits of opacity) become what the theme says.
  function themed(value) {
    if (typeof value === "string") {
      const named = value.match(/^@([a-z]+\d?)([0-9a-f]{2})?$/);
      return named ? colour(named[1]) + (named[2] ?? "") : value;
    }
    if (Array.isArray(value)) return value.map(themed);
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, themed(inner)]));
  }

  function axes(layout) {
    const look = { gridcolor: colour("grid"), linecolor: colour("line"), zerolinecolor: colour("line"),
      showline: true, nticks: 5 };
    return Object.fromEntries(Object.entries(layout).filter(([key]) => /^[xy]axis\d*$/.test(key))
      .map(([key, own]) => [key, { ...look, ...own,
        title: { standoff: 8, font: { size: 12 }, ...own.title } }]));
  }

  function figureOf(spec) {
    const own = themed(spec.layout);
    const margin = { ...MARGIN, ...own.margin };
    const inner = spec.height - margin.t - margin.b;
    const layout = { ...own, ...axes(own), margin,
      paper_bgcolor: colour("paper"), plot_bgcolor: colour("paper"),
      font: { color: colour("ink"), size: 12, family: getComputedStyle(document.body).fontFamily },
      legend: { orientation: "h", x: 0, y: 1 + 28 / inner, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)" },
      hoverlabel: { bgcolor: colour("faint"), font: { color: colour("ink") } },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("quiet"), activecolor: colour("ink") } };
    return { data: themed(spec.data), layout };
  }

  async function drawAll() {
    for (const spec of specs) {
      await new Promise((resume) => setTimeout(resume)); // let the page scroll between figures
      const { data, layout } = figureOf(spec);
      await Plotly.react(document.getElementById(spec.id), data, layout, CONFIG);
    }
    document.documentElement.dataset.figures = "drawn";
  }

  async function copy(button) {
    await navigator.clipboard.writeText(button.dataset.text);
    button.textContent = "copied";
    setTimeout(() => { button.textContent = "copy command"; }, 1500);
  }

  document.querySelectorAll("button.copy").forEach((b) => b.addEventListener("click", () => copy(b)));
  // Paper has a width of its own [px]: an A4 page across, without its margins.
  function fit(width) {
    const drawn = specs.map((s) => document.getElementById(s.id)).filter((div) => div.data);
    drawn.forEach((div) => Plotly.relayout(div, { width, autosize: width === null }));
  }

  window.addEventListener("beforeprint", () => fit(1030));
  window.addEventListener("afterprint", () => fit(null));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  drawAll();
})();
