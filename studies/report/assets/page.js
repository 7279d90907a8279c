"use strict";
/* Lets the figures of a page answer: curves and loops are drawn anew, maps say their values, sliders choose a frame. */
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const cache = new Map();
  const mounted = [];

  // Arrays lie packed as base64, least significant byte first.
  function take(number) {
    if (!cache.has(number)) {
      const [kind, text] = Object.entries(data.arrays[number])[0];
      const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
      cache.set(number, kind === "f8" ? new Float64Array(bytes.buffer) : new Float32Array(bytes.buffer));
    }
    return cache.get(number);
  }
  const frameOf = (list, frame) => take(list[frame % list.length]);

  function chartOf(figure, frame) {
    const x = figure.x.values.length ? frameOf(figure.x.values, frame) : null;
    const series = figure.series.map((line) => ({ ...line, values: frameOf(line.values, frame), x: line.x ? frameOf(line.x, frame) : x }));
    // Lines that share the axis need none of their own: they are joined only where they must be.
    if (figure.kind === "curves" && x) figure.series.forEach((line, i) => { if (!line.x) series[i].x = undefined; });
    return { ...figure, x: { ...figure.x, values: x }, series };
  }

  function mountCurves(element, figure, frame) {
    const isLoop = figure.kind === "loops";
    const handle = (isLoop ? apesimCurves.drawLoops : apesimCurves.draw)(element.querySelector(".stage"), chartOf(figure, frame));
    element.classList.add("mounted");
    return { show(number) { const chart = chartOf(figure, number); apesimCurves.update(handle, { x: chart.x.values, series: chart.series.map(({ values, x }) => x ? { values, x } : values) }); }, handle };
  }

  // The picture of a map stays; a frame marks the cell that is told. Other frames colour the cells anew.
  function mountMap(element, figure, frame) {
    const svg = element.querySelector("svg"), cells = svg.querySelector(".cells"), xs = take(figure.x.values), ys = take(figure.y.values);
    const readout = document.createElement("output"), mark = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    readout.className = "map-readout live";
    mark.setAttribute("class", "mark");
    mark.setAttribute("visibility", "hidden");
    svg.append(mark);
    element.classList.add("map");
    element.querySelector(".picture").after(readout);
    for (const [key, value] of [["tabindex", 0], ["role", "slider"], ["aria-valuemin", 0], ["aria-valuemax", xs.length * ys.length - 1], ["aria-valuenow", 0], ["aria-valuetext", "no cell chosen; arrow keys move over the map"]]) svg.setAttribute(key, value);
    let now = frame, at = null;
    const tell = (column, row) => {
      at = [column, row];
      const value = frameOf(figure.values, now)[row * xs.length + column];
      const [left, right] = figure.x.edges.slice(column, column + 2), [low, high] = figure.y.edges.slice(row, row + 2);
      for (const [key, number] of [["x", left], ["y", high], ["width", right - left], ["height", low - high]]) mark.setAttribute(key, number);
      mark.setAttribute("visibility", "visible");
      const said = (axis, number) => `${axis.label} ${apesimCurves.format(number)} ${axis.unit}`.trim();
      readout.textContent = `${said(figure.x, xs[column])}, ${said(figure.y, ys[row])}: ${said(figure.z, value)}`;
      svg.setAttribute("aria-valuenow", row * xs.length + column);
      svg.setAttribute("aria-valuetext", readout.textContent);
    };
    const cellAt = (edges, place) => {
      const isUp = edges[edges.length - 1] > edges[0];
      for (let k = 0; k + 1 < edges.length; k++) if (isUp ? place >= edges[k] && place < edges[k + 1] : place <= edges[k] && place > edges[k + 1]) return k;
      return -1;
    };
    svg.addEventListener("pointermove", (event) => {
      const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
      const column = cellAt(figure.x.edges, (event.clientX - box.left) * scale), row = cellAt(figure.y.edges, (event.clientY - box.top) * scale);
      if (column >= 0 && row >= 0) tell(column, row);
    });
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
      if (!step) return;
      const [column, row] = at ?? [0, 0], clamp = (k, count) => Math.max(0, Math.min(count - 1, k));
      tell(clamp(column + (at ? step[0] : 0), xs.length), clamp(row + (at ? step[1] : 0), ys.length));
      event.preventDefault();
    });
    return {
      show(number) {
        now = number;
        const values = frameOf(figure.values, number), [low, high] = figure.z.range;
        svg.querySelectorAll("text.in").forEach((text) => text.remove());
        cells.replaceChildren();
        for (let row = 0; row < ys.length; row++) {
          for (let column = 0; column < xs.length; column++) {
            const value = values[row * xs.length + column];
            if (!Number.isFinite(value)) continue;
            const rect = document.createElementNS("http://www.w3.org/2000/svg", "rect");
            const [left, right] = figure.x.edges.slice(column, column + 2), [foot, top] = figure.y.edges.slice(row, row + 2);
            for (const [key, text] of [["x", left], ["y", top], ["width", right - left + 0.3], ["height", foot - top + 0.3], ["fill", colourAt((value - low) / (high - low))]]) rect.setAttribute(key, text);
            cells.append(rect);
          }
        }
        if (at) tell(...at);
      },
    };
  }

  // Valve and crank move with the cursor of the curves beside them, and the cursor with them.
  function mountMoving(element, figure, frame) {
    const handle = apesimMotion.mount(element.querySelector(".motion"), figure.geometry);
    let now = frame, isOwn = false, isTold = false;
    const tracesOf = (number) => {
      const traces = { label: figure.x.label, unit: figure.x.unit === "deg" ? "°" : figure.x.unit, period: figure.period, x: frameOf(figure.x.values, number) };
      if (figure.still !== null) traces.start = figure.still;
      for (const [key, { factor, values }] of Object.entries(figure.traces)) traces[key] = frameOf(values, number).map((value) => value * factor);
      return traces;
    };
    const onMove = (x) => {
      if (isTold) return;
      const xs = frameOf(figure.x.values, now);
      let k = 0;
      while (k + 1 < xs.length && Math.abs(xs[k + 1] - x) <= Math.abs(xs[k] - x)) k++;
      isOwn = true;
      companions(element).forEach(({ handle: other }) => other.move(k, figure.line));
      isOwn = false;
    };
    const player = apesimMotion.play(handle, tracesOf(frame), onMove);
    queueMicrotask(() => companions(element).forEach(({ handle: other }) => {
      other.onMove = (x, k) => {
        if (isOwn) return;
        player.stop();
        isTold = true;
        player.set(frameOf(figure.x.values, now)[k] ?? x);
        isTold = false;
      };
    }));
    return { show(number) { now = number; player.traces(tracesOf(number)); } };
  }
  const companions = (element) => mounted.filter(([other, control]) => control.handle && other.dataset.of === element.dataset.of && other.closest("section") === element.closest("section")).map(([, control]) => control);

  const MOUNTS = { map: mountMap, moving: mountMoving, curves: mountCurves, loops: mountCurves };

  function colourAt(share) {
    const place = Math.min(Math.max(share, 0), 1) * (data.colours.length - 1), first = Math.min(Math.floor(place), data.colours.length - 2);
    const part = (text, k) => parseInt(text.slice(k, k + 2), 16);
    const mix = (k) => Math.round(part(data.colours[first], k) + (place - first) * (part(data.colours[first + 1], k) - part(data.colours[first], k)));
    return `rgb(${mix(1)} ${mix(3)} ${mix(5)})`;
  }

  document.querySelectorAll("figure[data-figure]").forEach((element) => {
    const figure = data.figures[element.dataset.figure], start = Number(element.dataset.frame ?? 0);
    const control = MOUNTS[figure.kind](element, figure, start);
    mounted.push([element, control]);
  });

  document.querySelectorAll(".hint").forEach((hint) => { hint.hidden = !data.figures.length; });

  // A slider shows a frame in all figures that name it.
  document.querySelectorAll("input[data-slider]").forEach((slider) => {
    const texts = data.sliders[slider.dataset.slider], output = slider.parentElement.querySelector("output");
    slider.disabled = false;
    slider.addEventListener("input", () => {
      const frame = Number(slider.value);
      output.textContent = texts[frame];
      slider.setAttribute("aria-valuetext", texts[frame]);
      mounted.forEach(([element, control]) => { if (element.dataset.of === slider.dataset.slider) control.show(frame); });
      slider.dispatchEvent(new CustomEvent("frame", { bubbles: true, detail: frame }));
    });
  });
  window.apesimPage = { data, take, mounted };
})();
