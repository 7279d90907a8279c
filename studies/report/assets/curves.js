"use strict";
/* Curves with a cursor (by uPlot), and loops such as p-V, for the pages of apesim.

   draw(element, {x: {label, unit, values}, y: {label, unit, range}, series: [{label, values, x, colour, dash, marker, line}],
   sync}) and drawLoops(element, the same, each series with its own x) give a handle for update(handle, {x, series}).
   A series is told apart by colour, dash and marker, each by its number; its place in the list if left out. */
const apesimCurves = (() => {
  const DASHES = [[], [8, 4], [2, 3], [11, 3, 2, 3], [16, 4], [5, 2, 1, 2]];
  const MARKERS = 6;
  const DIGITS = 5;  // of a value at the cursor
  const MAX_MARKED = 60;  // samples up to which each one bears a marker
  const ASPECT = 0.56, MIN_HEIGHT = 190, MAX_HEIGHT = 330;  // of a plot [px]
  const NEAR = 18;  // distance within which a point of a loop is at the pointer [px]
  const SVG = "http://www.w3.org/2000/svg";
  const handles = new Set();

  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const format = (value) => value == null || !Number.isFinite(value) ? "–" : String(Number(value.toPrecision(DIGITS))).replace("-", "−");
  const named = (axis) => axis.unit ? `${axis.label} [${axis.unit}]` : axis.label;
  const withUnit = (value, unit) => unit ? `${value} ${unit}` : value;

  function make(tag, attributes = {}, text = "") {
    const node = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.textContent = text;
    return node;
  }

  function makeSvg(tag, attributes, text = "") {
    const node = document.createElementNS(SVG, tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.textContent = text;
    return node;
  }

  // Outline of a marker about a point, as the text of an SVG path; the shapes are those of the still pictures.
  function markerPath(kind, x, y, r) {
    switch (kind % MARKERS) {
      case 0: return `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`;
      case 1: return `M${x - r} ${y - r}h${2 * r}v${2 * r}h${-2 * r}z`;
      case 2: return `M${x} ${y - 1.2 * r}L${x + 1.1 * r} ${y + 0.9 * r}H${x - 1.1 * r}z`;
      case 3: return `M${x} ${y - 1.3 * r}L${x + 1.3 * r} ${y}L${x} ${y + 1.3 * r}L${x - 1.3 * r} ${y}z`;
      case 4: return `M${x} ${y + 1.2 * r}L${x + 1.1 * r} ${y - 0.9 * r}H${x - 1.1 * r}z`;
      default: return `M${x - r} ${y - r}l${2 * r} ${2 * r}M${x - r} ${y + r}l${2 * r} ${-2 * r}`;
    }
  }

  const look = (series, i) => ({
    colour: `c${(series.colour ?? i) % 8}`,
    dash: series.line === false ? [] : DASHES[(series.dash ?? i) % DASHES.length],
    marker: series.marker === null ? null : (series.marker ?? i),
    line: series.line !== false,
  });
  const isMarked = (shown, count) => shown.marker !== null && (count <= MAX_MARKED || !shown.line);
  const isDark = matchMedia("(prefers-color-scheme: dark)");
  isDark.addEventListener("change", () => handles.forEach((handle) => handle.recolour()));

  function swatch(series, i, count) {
    const shown = look(series, i);
    const svg = makeSvg("svg", { width: 34, height: 12, "aria-hidden": "true" });
    if (shown.line) {
      svg.append(makeSvg("path", { d: "M1 6H33", fill: "none", stroke: `var(--${shown.colour})`, "stroke-width": 2, "stroke-dasharray": shown.dash.join(" ") }));
    }
    if (isMarked(shown, count)) {
      svg.append(makeSvg("path", { d: markerPath(shown.marker, 17, 6, 3.5), fill: shown.line ? "var(--paper)" : `var(--${shown.colour})`, stroke: `var(--${shown.colour})`, "stroke-width": 1.6 }));
    }
    return svg;
  }

  // What curves and loops share: the unit above, the plot, and the legend, whose entries switch series off and hold values.
  function frame(element, chart) {
    const box = make("div", { class: "curves live" });
    const plot = make("div", { class: "plot", tabindex: 0, role: "slider", "aria-label": `${named(chart.y)} over ${named(chart.x)}`, "aria-valuemin": 0, "aria-valuenow": 0, "aria-valuetext": "no point chosen; arrow keys move along the curve" });
    const head = make("div", { class: "head" }), place = make("span", { class: "place" }), legend = make("ul", { class: "legend" });
    head.append(make("span", {}, named(chart.y)), place);
    const outputs = chart.series.map((series, i) => {
      const item = make("li"), button = make("button", { type: "button", "aria-pressed": "true" }), value = make("b");
      button.append(swatch(series, i, series.values.length), make("span", {}, series.label), value);
      button.addEventListener("click", () => handle.toggle(i, button.getAttribute("aria-pressed") === "false"));
      item.append(button);
      legend.append(item);
      return { button, value };
    });
    box.append(head, plot, legend);
    element.append(box);
    const handle = { element, chart, box, plot, place, outputs, index: null, visible: chart.series.map(() => true) };
    return handle;
  }

  const heightFor = (chart, width) => chart.height ?? Math.round(Math.min(MAX_HEIGHT, Math.max(MIN_HEIGHT, ASPECT * width)));

  function watchSize(handle) {
    handle.observer = new ResizeObserver(() => {
      const width = handle.plot.clientWidth;
      if (width > 40 && width !== handle.width) handle.resize((handle.width = width), heightFor(handle.chart, width));
    });
    handle.observer.observe(handle.plot);
    handles.add(handle);
  }

  // --- curves over one axis

  const plain = (values) => Array.from(values, (value) => Number.isFinite(value) ? value : null);

  // Series that have an x of their own are joined on one axis: what is not there is spanned, what is NaN stays a gap.
  function tablesOf(chart) {
    if (chart.series.every((series) => !series.x)) return [Array.from(chart.x.values), ...chart.series.map((series) => plain(series.values))];
    return uPlot.join(chart.series.map((series) => [Array.from(series.x ?? chart.x.values), plain(series.values)]));
  }

  function ticks(values, step) {
    let digits = 0;  // as many as the step itself has: 0.25 has two
    while (digits < 9 && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-6) digits++;
    return values.map((value) => value == null ? "" : (value || 0).toFixed(digits).replace("-", "−"));
  }

  function markerPaths(kind) {
    return (plot, i, from, to) => {
      const path = new Path2D(), ratio = devicePixelRatio || 1, xs = plot.data[0], ys = plot.data[i], { min, max } = plot.scales.y;
      for (let k = from; k <= to; k++) {
        if (ys[k] != null && ys[k] >= min && ys[k] <= max) path.addPath(new Path2D(markerPath(kind, plot.valToPos(xs[k], "x", true), plot.valToPos(ys[k], "y", true), 3.4 * ratio)));
      }
      return { stroke: path, fill: path, flags: 3 };
    };
  }

  function draw(element, chart) {
    const handle = frame(element, chart);
    const data = tablesOf(chart), unit = chart.x.unit;
    const axis = (label) => ({
      stroke: () => colour("soft"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { stroke: () => colour("line"), size: 5 },
      font: "12px system-ui, sans-serif", values: (_, splits, __, ___, step) => ticks(splits, step), size: 28, label, labelFont: "12px system-ui, sans-serif", labelSize: 18, labelGap: 0,
    });
    const y = { ...axis(undefined), size: (_, values) => 14 + 7 * Math.max(2, ...(values ?? []).map((text) => text.length)), labelSize: 0 };

    // At a place of the joined axis, a series that has no sample there shows its nearest one.
    const nearest = (plot, i, index, value) => {
      const xs = plot.data[0], ys = plot.data[i];
      if (ys[index] != null || ys[index] === null) return index;
      let best = null;
      for (let k = 0; k < ys.length; k++) if (ys[k] != null && (best === null || Math.abs(xs[k] - value) < Math.abs(xs[best] - value))) best = k;
      return best ?? index;
    };
    const show = (plot) => {
      const index = plot.cursor.idx;
      if (index == null) return;
      handle.index = index;
      const at = plot.data[0][index];
      handle.place.textContent = `${chart.x.label} ${withUnit(format(at), unit)}`;
      handle.outputs.forEach(({ value }, i) => {
        const own = nearest(plot, i + 1, index, at);
        const text = format(plot.data[i + 1][own]);
        value.textContent = own === index ? text : `${text} at ${format(plot.data[0][own])}`;
      });
      describe(handle, plot.data[0].length);
      handle.onMove?.(at, index);
    };
    const options = {
      width: Math.max(60, handle.plot.clientWidth), height: heightFor(chart, handle.plot.clientWidth), legend: { show: false },
      cursor: { drag: { x: true, y: false }, sync: chart.sync ? { key: chart.sync } : undefined, dataIdx: nearest, points: { size: 8 } },
      scales: { x: { time: false }, y: chart.y.range ? { range: () => chart.y.range } : {} },
      axes: [axis(named(chart.x)), y],
      series: [{}, ...chart.series.map((series, i) => {
        const shown = look(series, i), ink = () => colour(shown.colour);
        return {
          label: series.label, stroke: ink, width: shown.line ? 1.8 : 0, dash: shown.dash, paths: shown.line ? undefined : () => null,
          points: { show: isMarked(shown, series.values.length), paths: markerPaths(shown.marker ?? 0), stroke: ink, fill: shown.line ? () => colour("paper") : ink, width: 1.6 },
        };
      })],
      hooks: { setCursor: [show] },
    };
    handle.width = handle.plot.clientWidth;
    handle.uplot = new uPlot(options, data, handle.plot);
    handle.recolour = () => handle.uplot.redraw(false, true);
    handle.resize = (width, height) => handle.uplot.setSize({ width, height });
    handle.toggle = (i, isOn) => { setPressed(handle, i, isOn); handle.uplot.setSeries(i + 1, { show: isOn }); };
    handle.refresh = () => { handle.uplot.setData(tablesOf(chart), !chart.y.range); show(handle.uplot); };
    handle.move = (index) => {
      const plot = handle.uplot, last = plot.data[0].length - 1, to = Math.min(last, Math.max(0, index));
      plot.setCursor({ left: plot.valToPos(plot.data[0][to], "x"), top: plot.over.clientHeight / 2 });
    };
    handle.plot.addEventListener("keydown", (event) => {
      const last = handle.uplot.data[0].length - 1, now = handle.index ?? -1, far = event.shiftKey ? 10 : 1;
      const to = { ArrowLeft: now - far, ArrowRight: now + far, ArrowDown: now - far, ArrowUp: now + far, PageDown: now - 10, PageUp: now + 10, Home: 0, End: last }[event.key];
      if (to !== undefined) handle.move(to);
      else if (event.key === "Escape") handle.uplot.setScale("x", { min: handle.uplot.data[0][0], max: handle.uplot.data[0][last] });
      else return;
      event.preventDefault();
    });
    watchSize(handle);
    return handle;
  }

  function setPressed(handle, i, isOn) {
    handle.visible[i] = isOn;
    handle.outputs[i].button.setAttribute("aria-pressed", String(isOn));
  }

  function describe(handle, count) {
    const values = handle.outputs.map(({ value }, i) => handle.visible[i] ? `${handle.chart.series[i].label} ${value.textContent}` : "").filter(Boolean);
    handle.plot.setAttribute("aria-valuemax", count - 1);
    handle.plot.setAttribute("aria-valuenow", handle.index);
    handle.plot.setAttribute("aria-valuetext", `${handle.place.textContent}: ${values.join("; ")}`);
  }

  // --- loops: y over x, where x goes forth and back

  function niceTicks(low, high, count) {
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= raw * 0.999);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    return [found, step];
  }

  function extent(lists, given) {
    if (given) return given;
    let low = Infinity, high = -Infinity;
    for (const list of lists) for (const value of list) if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
    if (!(high >= low)) return [0, 1];
    const room = 0.04 * (high - low || 1);
    return [low - room, high + room];
  }

  function drawLoops(element, chart) {
    const handle = frame(element, chart);
    const edge = { left: 46, right: 10, top: 8, bottom: 40 };
    let scale = null, dot = null;

    const render = (width, height) => {
      const shown = chart.series.filter((_, i) => handle.visible[i]);
      const [x0, x1] = extent(shown.map((series) => series.x), chart.x.range), [y0, y1] = extent(shown.map((series) => series.values), chart.y.range);
      const right = width - edge.right, bottom = height - edge.bottom;
      const toX = (x) => edge.left + (x - x0) / (x1 - x0) * (right - edge.left), toY = (y) => bottom - (y - y0) / (y1 - y0) * (bottom - edge.top);
      const svg = makeSvg("svg", { width, height, "aria-hidden": "true" });
      const [xs, stepX] = niceTicks(x0, x1, Math.max(3, width / 90)), [ys, stepY] = niceTicks(y0, y1, Math.max(3, height / 55));
      ticks(xs, stepX).forEach((text, k) => svg.append(makeSvg("path", { class: "grid", d: `M${toX(xs[k])} ${edge.top}V${bottom}` }), makeSvg("text", { x: toX(xs[k]), y: bottom + 16, "font-size": 12, "text-anchor": "middle" }, text)));
      ticks(ys, stepY).forEach((text, k) => svg.append(makeSvg("path", { class: "grid", d: `M${edge.left} ${toY(ys[k])}H${right}` }), makeSvg("text", { x: edge.left - 6, y: toY(ys[k]) + 4, "font-size": 12, "text-anchor": "end" }, text)));
      svg.append(makeSvg("text", { x: (edge.left + right) / 2, y: height - 6, "font-size": 12, "text-anchor": "middle" }, named(chart.x)));
      svg.append(makeSvg("path", { class: "axis", d: `M${edge.left} ${edge.top}V${bottom}H${right}` }));
      chart.series.forEach((series, i) => {
        if (!handle.visible[i]) return;
        const own = look(series, i);
        let text = "", isPen = false;
        for (let k = 0; k < series.x.length; k++) {
          const isThere = Number.isFinite(series.x[k]) && Number.isFinite(series.values[k]);
          if (isThere) text += `${isPen ? "L" : "M"}${toX(series.x[k]).toFixed(1)} ${toY(series.values[k]).toFixed(1)}`;
          isPen = isThere;
        }
        if (!own.line) {
          const marks = Array.from(series.x, (x, k) => Number.isFinite(x) && Number.isFinite(series.values[k]) ? markerPath(own.marker ?? 0, toX(x), toY(series.values[k]), 3.4) : "");
          svg.append(makeSvg("path", { d: marks.join(""), fill: `var(--${own.colour})`, stroke: `var(--${own.colour})`, "stroke-width": 1.6 }));
          return;
        }
        svg.append(makeSvg("path", { d: text, fill: "none", stroke: `var(--${own.colour})`, "stroke-width": 1.8, "stroke-dasharray": own.dash.join(" "), "stroke-linejoin": "round" }));
      });
      dot = makeSvg("circle", { r: 4.5, fill: "var(--paper)", stroke: "var(--ink)", "stroke-width": 2, visibility: "hidden" });
      svg.append(dot);
      handle.plot.replaceChildren(svg);
      scale = { toX, toY };
      if (handle.at) show(...handle.at);
    };
    const show = (i, k) => {
      const series = chart.series[i];
      if (!series || k >= series.x.length) return;
      handle.at = [i, k];
      handle.index = k;
      handle.place.textContent = `${chart.x.label} ${withUnit(format(series.x[k]), chart.x.unit)}`;
      handle.outputs.forEach(({ value }, other) => { value.textContent = other === i ? format(series.values[k]) : ""; });
      for (const [key, value] of [["cx", scale.toX(series.x[k])], ["cy", scale.toY(series.values[k])], ["visibility", "visible"]]) dot.setAttribute(key, value);
      describe(handle, series.x.length);
      handle.onMove?.(series.x[k], k, i);
    };
    handle.plot.addEventListener("pointermove", (event) => {
      const box = handle.plot.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      let best = null, least = NEAR * NEAR;
      chart.series.forEach((series, i) => {
        if (!handle.visible[i]) return;
        for (let k = 0; k < series.x.length; k++) {
          const away = (scale.toX(series.x[k]) - x) ** 2 + (scale.toY(series.values[k]) - y) ** 2;
          if (away < least) [best, least] = [[i, k], away];
        }
      });
      if (best) show(...best);
    });
    handle.plot.addEventListener("keydown", (event) => {
      const [i, k] = handle.at ?? [handle.visible.indexOf(true), -1];
      if (i < 0) return;
      const count = chart.series[i].x.length, far = event.shiftKey ? 10 : 1;
      const along = { ArrowRight: far, ArrowLeft: -far, PageUp: 10, PageDown: -10 }[event.key];
      if (along) show(i, (k + along + count) % count);
      else if (event.key === "Home") show(i, 0);
      else if (event.key === "End") show(i, count - 1);
      else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
        const shown = handle.visible.flatMap((isOn, other) => isOn ? [other] : []);
        const next = shown[(shown.indexOf(i) + (event.key === "ArrowUp" ? shown.length - 1 : 1)) % shown.length];
        show(next, Math.max(0, Math.min(k, chart.series[next].x.length - 1)));
      } else return;
      event.preventDefault();
    });
    handle.move = (k, i) => { const chosen = i ?? handle.at?.[0] ?? handle.visible.indexOf(true); if (chosen >= 0) show(chosen, k); };
    handle.recolour = () => {};  // its colours are variables of the style
    handle.resize = render;
    handle.refresh = () => render(handle.width, heightFor(chart, handle.width));
    handle.toggle = (i, isOn) => { setPressed(handle, i, isOn); handle.at = null; handle.refresh(); };
    handle.width = Math.max(60, handle.plot.clientWidth);
    handle.refresh();
    watchSize(handle);
    return handle;
  }

  // New values for a chart that is drawn: {x: values, series: [values or {x, values}]}, each where it changes.
  function update(handle, data) {
    if (data.x) handle.chart.x.values = data.x;
    (data.series ?? []).forEach((given, i) => {
      if (given == null) return;
      const isPlain = Array.isArray(given) || ArrayBuffer.isView(given);
      Object.assign(handle.chart.series[i], isPlain ? { values: given } : given);
    });
    if (data.range) handle.chart.y.range = data.range;
    handle.refresh();
  }

  function remove(handle) {
    handle.observer.disconnect();
    handle.uplot?.destroy();
    handles.delete(handle);
    handle.box.remove();
  }

  return { draw, drawLoops, update, remove, format, named, colour, niceTicks };
})();
