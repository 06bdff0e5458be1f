// Draws the figures of <script id="figures"> with plotly.js: theme from CSS, zoom shared by all.
(() => {
  "use strict";
  const specs = JSON.parse(document.getElementById("figures").textContent);
  const menu = document.getElementById("zoom");
  const MARKS = { slipping: "triangle-up", engaged: "circle", disengaged: "triangle-down-open" };
  const STYLES = {
    truth: { width: 2.6 }, engine: { width: 3 }, map: { width: 1.6, dash: "dash" }, observer: { width: 1.5 },
    method2: { width: 1.5, dash: "dashdot" }, method3: { width: 1.5 }, method4: { width: 1.5, dash: "6px,2px" },
    method5: { width: 1.5 }, frozen: { width: 1.4, dash: "dot" }, closed: { width: 1.6 }, opened: { width: 1.5, dash: "dash" },
  };
  const BEFORE = { width: 1.3, dash: "dot" }; // a line of the run to compare with
  const PIXELS = { left: 78, right: 12, top: 64, bottom: 46, gap: 16, heading: 40, letter: 6 };
  const NARROW = 1000; // page width [px] below which panels stand below each other
  const SHEET = { width: 1030, height: 640 }; // [px] of an A4 page across, with a heading
  const MOST_LEAD = 200; // [px]: a heading and some lines
  const CONFIG = {
    responsive: true, displaylogo: false, scrollZoom: false, doubleClick: false,
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d", "resetScale2d"],
  };
  let range = null; // shared time window [s], null for the whole scenario
  let sharing = false;

  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  function axisNames(k) {
    const suffix = k === 0 ? "" : String(k + 1);
    return { x: `x${suffix}`, y: `y${suffix}`, xaxis: `xaxis${suffix}`, yaxis: `yaxis${suffix}` };
  }

  // A figure over something else than time, `across`, keeps its own range.
  const windowOf = (spec) => (spec.across ? spec.range : range ?? spec.range);
  const above = (spec) => (spec.legend === false ? PIXELS.heading : PIXELS.top);

  const gapOf = (spec) => (spec.panels.some((p) => p.heading) ? PIXELS.heading : PIXELS.gap);

  // On a narrow page, where headings and labels beside each other would overlap: one column.
  function stack(spec) {
    const gap = gapOf(spec);
    const around = above(spec) + PIXELS.bottom - gap;
    const row = (spec.height - around) / Math.ceil(spec.panels.length / spec.columns);
    spec.height = Math.round(around + row * spec.panels.length);
    spec.columns = 1;
    document.getElementById(spec.id).style.height = `${spec.height}px`;
  }

  // Panels row by row; returns for each its domain in paper units and whether it is lowest.
  function place(spec) {
    const rows = Math.ceil(spec.panels.length / spec.columns);
    const height = spec.height - above(spec) - PIXELS.bottom;
    const gap = gapOf(spec) / height;
    const weights = Array.from({ length: rows }, (_, r) => spec.panels[r * spec.columns].weight ?? 1);
    const unit = (1 - gap * (rows - 1)) / weights.reduce((a, b) => a + b, 0);
    const across = spec.columns > 1 ? 0.07 : 0;
    const width = (1 - across * (spec.columns - 1)) / spec.columns;
    let top = 1;
    const bands = weights.map((weight) => {
      const band = [Math.max(0, top - weight * unit), Math.min(1, top)];
      top -= weight * unit + gap;
      return band;
    });
    return spec.panels.map((_, k) => {
      const column = k % spec.columns;
      const left = column * (width + across);
      const lowest = k + spec.columns >= spec.panels.length;
      return { y: bands[Math.floor(k / spec.columns)], x: [left, Math.min(1, left + width)], lowest };
    });
  }

  if (window.innerWidth < NARROW) specs.filter((s) => s.columns > 1).forEach(stack);

  function traceOf(raw, k, seen, legend) {
    const names = axisNames(k);
    const common = { x: raw.x, y: raw.y, xaxis: names.x, yaxis: names.y, name: raw.name };
    if (raw.role === "event") {
      return { ...common, mode: "markers", type: "scatter", text: raw.text, showlegend: false,
        hovertemplate: "%{text}<br>t = %{x:.3f} s<extra></extra>",
        marker: { symbol: raw.to.map((s) => MARKS[s] ?? "diamond"), size: 8, color: colour("ink"),
          line: { width: 1.2, color: colour("paper") } } };
    }
    if (raw.role === "band") {
      const named = legend && raw.fill && !seen.has(raw.name);
      if (raw.fill) seen.add(raw.name);
      return { ...common, mode: "lines", type: "scatter", showlegend: named, hoverinfo: "skip",
        legendgroup: raw.name, line: { width: 0.6, color: colour("observer") },
        fill: raw.fill ? "tonexty" : "none", fillcolor: `${colour("observer")}2e` };
    }
    const first = legend && !seen.has(raw.name);
    seen.add(raw.name);
    return { ...common, mode: "lines", type: "scatter", showlegend: first, legendgroup: raw.name,
      line: { width: 1.6, ...STYLES[raw.role], ...(raw.before ? BEFORE : {}), color: colour(raw.role) },
      opacity: raw.before ? 0.75 : 1,
      hovertemplate: "%{y:.4g}" };
  }

  function shadesOf(panel, k) {
    const names = axisNames(k);
    return (panel.shades ?? []).filter((s) => s.state !== "disengaged").map((s) => ({
      type: "rect", layer: "below", xref: names.x, yref: `${names.y} domain`, line: { width: 0 },
      x0: s.x0, x1: s.x1, y0: s.y0, y1: s.y1,
      fillcolor: colour(s.state), opacity: s.solid ? 0.85 : Number(colour("tint")),
    }));
  }

  // Names above the panels; every other phase is shaded from its name down.
  function phasesOf(spec, plotHeight) {
    const bands = spec.phases.filter((_, k) => k % 2 === 0).map((p) => ({
      type: "rect", layer: "below", xref: "x", yref: "paper", x0: p.start, x1: p.end,
      y0: 0, y1: 1 + 17 / plotHeight, line: { width: 0 }, fillcolor: colour("phase"),
    }));
    const lines = spec.phases.map((p) => ({
      type: "line", layer: "below", xref: "x", yref: "paper", x0: p.start, x1: p.start, y0: 0, y1: 1,
      line: { width: 1, dash: "dot", color: colour("quiet") },
    }));
    return { bands, lines };
  }

  // Names of the phases in sight, where they have room.
  function namesOf(spec, outer = document.getElementById(spec.id).clientWidth) {
    const [a, b] = range ?? spec.range;
    const width = outer - PIXELS.left - PIXELS.right;
    const seen = spec.phases.map((p) => ({ text: p.name, x0: Math.max(a, p.start), x1: Math.min(b, p.end) }));
    return seen.filter((p) => ((p.x1 - p.x0) / (b - a)) * width > PIXELS.letter * p.text.length).map((p) => ({
      text: p.text, xref: "x", yref: "paper", x: (p.x0 + p.x1) / 2, y: 1, yanchor: "bottom",
      showarrow: false, font: { size: 11, color: colour("quiet") },
    }));
  }

  function headingsOf(spec, places) {
    return spec.panels.map((panel, k) => [panel, places[k]]).filter(([panel]) => panel.heading)
      .map(([panel, at]) => ({
        text: panel.heading, xref: "paper", yref: "paper", x: at.x[0], y: at.y[1],
        xanchor: "left", yanchor: "bottom", showarrow: false, font: { size: 12 },
      }));
  }

  function axesOf(spec, places) {
    const axes = {};
    const look = { gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false,
      showline: true, exponentformat: "power", title: { standoff: 6, font: { size: 12 } } };
    spec.panels.forEach((panel, k) => {
      const names = axisNames(k);
      const at = places[k];
      axes[names.xaxis] = { ...look, domain: at.x, anchor: names.y, matches: k ? "x" : undefined,
        showticklabels: at.lowest, range: [...windowOf(spec)], autorange: false,
        title: { ...look.title, text: at.lowest ? spec.across ?? "time [s]" : "" }, hoverformat: ".3f",
        ticksuffix: "", rangemode: "normal" };
      axes[names.yaxis] = { ...look, domain: at.y, anchor: names.x, fixedrange: Boolean(panel.ticks),
        title: { ...look.title, text: panel.ticks ? "" : panel.title }, nticks: 6,
        zeroline: !panel.ticks, zerolinecolor: colour("line") };
      if (panel.ticks) {
        Object.assign(axes[names.yaxis], { tickvals: panel.ticks.vals, ticktext: panel.ticks.text,
          range: panel.ticks.range, showgrid: false });
      }
    });
    return axes;
  }

  function figureOf(spec) {
    const places = place(spec);
    const seen = new Set();
    const legend = spec.legend !== false;
    const data = spec.panels.flatMap((p, k) => p.traces.map((t) => traceOf(t, k, seen, legend)));
    const plotHeight = spec.height - above(spec) - PIXELS.bottom;
    const phases = phasesOf(spec, plotHeight);
    const layout = {
      ...axesOf(spec, places), height: spec.height, hovermode: "x unified", dragmode: "zoom",
      paper_bgcolor: colour("paper"), plot_bgcolor: colour("paper"),
      font: { color: colour("ink"), size: 12, family: getComputedStyle(document.body).fontFamily },
      margin: { l: PIXELS.left, r: PIXELS.right, t: above(spec), b: PIXELS.bottom },
      shapes: [...phases.bands, ...spec.panels.flatMap(shadesOf), ...phases.lines],
      annotations: [...namesOf(spec), ...headingsOf(spec, places)],
      legend: { orientation: "h", x: 0, y: 1 + 20 / plotHeight, yanchor: "bottom",
        bgcolor: "rgba(0,0,0,0)" },
      hoverlabel: { bgcolor: colour("faint"), font: { color: colour("ink") } },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("quiet"), activecolor: colour("ink") },
    };
    return { data, layout };
  }

  function view(spec) {
    const annotations = [...namesOf(spec), ...headingsOf(spec, place(spec))];
    return { "xaxis.range": [...windowOf(spec)], annotations };
  }

  // Give every drawn figure the shared window; the one that started it has it already.
  async function share(window, source) {
    range = window;
    const value = window ? `${window[0]},${window[1]}` : "";
    menu.value = value;
    if (menu.value !== value) menu.value = "custom";
    sharing = true;
    try {
      for (const spec of specs.filter((s) => !s.across)) {
        const div = document.getElementById(spec.id);
        if (div === source) await Plotly.relayout(div, { annotations: view(spec).annotations });
        else if (div.data) await Plotly.relayout(div, view(spec));
      }
    } finally {
      sharing = false;
    }
  }

  function onRelayout(div, change) {
    if (sharing) return;
    const key = Object.keys(change).find((k) => /^xaxis\d*\.(range\[0\]|range|autorange)$/.test(k));
    if (!key) return;
    const now = div._fullLayout.xaxis;
    share(key.endsWith("autorange") ? null : [...now.range], div);
  }

  function onKey(div, event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target !== div) return;
    const [a, b] = div._fullLayout.xaxis.range;
    const span = b - a;
    const moves = {
      ArrowLeft: [a - span / 10, b - span / 10], ArrowRight: [a + span / 10, b + span / 10],
      "+": [a + span / 8, b - span / 8], "=": [a + span / 8, b - span / 8],
      "-": [a - span / 6, b + span / 6], 0: null, Home: null,
    };
    if (!(event.key in moves)) return;
    event.preventDefault();
    share(moves[event.key], null);
  }

  async function draw(spec) {
    const div = document.getElementById(spec.id);
    const { data, layout } = figureOf(spec);
    await Plotly.newPlot(div, data, layout, CONFIG);
    if (spec.across) return;
    div.on("plotly_relayout", (change) => onRelayout(div, change));
    div.on("plotly_doubleclick", () => share(null, null));
    div.addEventListener("keydown", (event) => onKey(div, event));
  }

  async function drawAll() {
    for (const spec of specs) {
      await new Promise((resume) => setTimeout(resume)); // let the page scroll between figures
      await draw(spec);
    }
    document.documentElement.dataset.figures = "drawn";
  }

  async function retheme() {
    for (const spec of specs) {
      const div = document.getElementById(spec.id);
      const { data, layout } = figureOf(spec);
      if (div.data) await Plotly.react(div, data, layout, CONFIG);
    }
  }

  // Height [px] of what stands above the first figure of a section, and goes onto its sheet; 0 where that is much.
  function lead(div) {
    const [figure, section] = ["figure", "section"].map((name) => div.closest(name));
    const height = figure.getBoundingClientRect().top - section.getBoundingClientRect().top;
    return height < MOST_LEAD ? height : 0;
  }

  // Paper has a size of its own. Printing does not wait: what plotly.js draws at once is printed.
  function fit(sheet) {
    for (const spec of specs) {
      const div = document.getElementById(spec.id);
      if (!div.data) continue;
      const height = sheet ? Math.min(spec.height, sheet.height - lead(div)) : spec.height;
      div.style.height = `${height}px`;
      const annotations = [...namesOf(spec, sheet?.width), ...headingsOf(spec, place(spec))];
      Plotly.relayout(div, { width: sheet?.width ?? null, autosize: !sheet, height, annotations });
    }
  }

  window.addEventListener("beforeprint", () => fit(SHEET));
  window.addEventListener("afterprint", () => fit(null));
  menu.addEventListener("change", () => {
    share(menu.value ? menu.value.split(",").map(Number) : null, null);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", retheme);
  drawAll();
})();
