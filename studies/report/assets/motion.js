"use strict";
/* Moves the picture that motion.py draws: parts by data-part, air by data-air, numbers by data-value.

   mount(element, geometry) gives a handle for show(handle, {angle, lift, pA, pB, pCylinder, pReceiver}) [deg, m, Pa abs], and
   for play(handle, traces, onMove), which reveals a slider and a button: traces = {label, unit, period, start, x, angle, lift, pA,
   pB, pCylinder, pReceiver}, arrays over x, shown at start first; angle is x where it is left out, and period is 0 where x
   is a time. play gives {set(x), stop(), toggle(), traces(others)}. */
const apesimMotion = (() => {
  const RAD = Math.PI / 180, MEGA = 1e6, MILLI = 1e3;
  const PASS_SECONDS = 6;  // a turn, or a whole trace, in slow motion
  const STILLS = 24, STILL_SECONDS = 0.5;  // pictures of a turn where motion is not wanted, and how long each stays
  const STATES = ["angle", "lift", "pA", "pB", "pCylinder", "pReceiver"];
  const AIRS = { a: "pA", b: "pB", cylinder: "pCylinder", receiver: "pReceiver" };
  const wantsStills = matchMedia("(prefers-reduced-motion: reduce)");

  // What is found under each name of a kind of mark.
  function marked(element, kind) {
    const found = {};
    for (const node of element.querySelectorAll(`[data-${kind}]`)) (found[node.dataset[kind]] ||= []).push(node);
    return found;
  }

  function mount(element, geometry) {
    return { element, geometry, parts: marked(element, "part"), airs: marked(element, "air"), values: marked(element, "value"), state: {} };
  }

  const part = (handle, name) => handle.parts[name] ?? [];
  const move = (handle, name, transform) => part(handle, name).forEach((node) => node.setAttribute("transform", transform));
  const size = (handle, name, place) => part(handle, name).forEach((node) => Object.entries(place).forEach((pair) => node.setAttribute(...pair)));
  const write = (handle, name, text) => (handle.values[name] ?? []).forEach((node) => { if (node.textContent !== text) node.textContent = text; });
  const within = (value) => Math.min(Math.max(value, 0), 1);
  const turned = (angle) => ((angle % 360) + 360) % 360;

  // Share of the exhaust that is open: flanks of a raised cosine inside its window.
  function openShare([opens, closes, flank], angle) {
    const since = turned(angle - opens), inside = Math.min(since, closes - opens - since);
    return inside <= 0 ? 0 : 0.5 - 0.5 * Math.cos(Math.PI * within(inside / flank));
  }

  function showAngle(handle, angle) {
    const engine = handle.geometry.engine, [x, y] = engine.origin;
    const across = engine.crank * Math.sin(angle * RAD) - engine.offset;
    const pin = engine.crank * Math.cos(angle * RAD) + Math.sqrt(engine.rod ** 2 - across ** 2);
    move(handle, "crank", `translate(${x} ${y}) rotate(${angle})`);
    move(handle, "rod", `translate(${x + engine.offset} ${y - pin}) rotate(${-Math.asin(across / engine.rod) / RAD})`);
    move(handle, "piston", `translate(${x + engine.offset} ${y - pin + engine.pin})`);
    size(handle, "charge", { height: Math.max(engine.head - pin - engine.crown, 0) });
    move(handle, "exhaust", `translate(0 ${engine.exhaustLift * openShare(engine.exhaust, angle)})`);
    write(handle, "angle", turned(Math.round(angle)).toFixed(0));
  }

  function showLift(handle, lift) {
    const { valves, lap, stroke } = handle.geometry, mm = lift * MILLI;
    for (const [name, valve] of Object.entries(valves)) {
      const up = valve.scale * mm, a = Math.max(valve.closedA - up, 0), b = Math.max(valve.closedB + up, 0);
      move(handle, `valve-${name}`, `translate(0 ${-up})`);
      size(handle, `chamber-a-${name}`, { height: a });
      size(handle, `chamber-b-${name}`, { y: valve.floor - b, height: b });
      if (name !== "large") continue;
      move(handle, "pointer", `translate(0 ${-up})`);
      for (const [spring, length, top] of [["low", b, valve.floor - b], ["high", a, null]]) {
        part(handle, `spring-${spring}`).forEach((node) => {
          const matrix = node.transform.baseVal.consolidate().matrix;
          node.setAttribute("transform", `translate(${matrix.e} ${top ?? matrix.f}) scale(1 ${length})`);
        });
      }
    }
    size(handle, "flow", { opacity: within((mm - lap) / (stroke - lap)) });
    write(handle, "lift", mm.toFixed(2));
  }

  function show(handle, state) {
    const { lowest, highest, engine } = handle.geometry;
    Object.assign(handle.state, state);
    if (engine && state.angle !== undefined) showAngle(handle, state.angle);
    if (state.lift !== undefined) showLift(handle, state.lift);
    for (const [name, key] of Object.entries(AIRS)) {
      const pressure = state[key];
      if (pressure === undefined) continue;
      const share = `${100 * within((pressure - lowest) / (highest - lowest))}%`;
      (handle.airs[name] ?? []).forEach((node) => node.style.setProperty("--high", share));
      write(handle, name, (pressure / MEGA).toFixed(2));
    }
  }

  // State of traces at an x, linear between two rows.
  function stateAt(traces, x) {
    const xs = traces.x, last = xs.length - 1;
    let low = 0, high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] <= x) low = middle; else high = middle;
    }
    const share = within((x - xs[low]) / (xs[high] - xs[low] || 1)), state = {};
    for (const name of STATES) {
      const rows = traces[name];
      if (rows && Number.isFinite(rows[low]) && Number.isFinite(rows[high])) state[name] = rows[low] + share * (rows[high] - rows[low]);
    }
    if (!traces.angle && traces.period) state.angle = x;
    return state;
  }

  function play(handle, given, onMove) {
    let traces = given, frame = null, before = null;
    const controls = handle.element.querySelector(".motion-controls");
    const [slider, button, output] = [".motion-slider", ".motion-play", ".motion-at"].map((name) => controls.querySelector(name));
    const ends = () => [traces.x[0], traces.x[traces.x.length - 1]];
    slider.setAttribute("aria-label", traces.label);
    controls.hidden = false;

    const set = (x) => {
      const [first, last] = ends(), length = last - first;
      const at = traces.period ? first + ((x - first) % length + length) % length : Math.min(Math.max(x, first), last);
      slider.value = at;
      output.textContent = `${Number(at.toPrecision(4))}${traces.unit === "°" ? "" : " "}${traces.unit}`;
      slider.setAttribute("aria-valuetext", `${traces.label} ${output.textContent}`);
      show(handle, stateAt(traces, at));
      onMove?.(at);
    };
    const stop = () => {
      cancelAnimationFrame(frame);
      frame = before = null;
      button.textContent = "Play";
      button.setAttribute("aria-pressed", "false");
    };
    const step = (now) => {
      const [first, last] = ends(), stills = wantsStills.matches;
      const seconds = before === null ? 0 : (now - before) / MILLI;
      if (before === null || !stills || seconds >= STILL_SECONDS) {
        const share = stills ? (before === null ? 0 : 1 / STILLS) : seconds / PASS_SECONDS;
        const at = Number(slider.value) + share * (last - first);
        set(!traces.period && at > last ? first : at);
        before = now;
      }
      frame = requestAnimationFrame(step);
    };
    const toggle = () => {
      if (frame !== null) return stop();
      button.textContent = "Pause";
      button.setAttribute("aria-pressed", "true");
      frame = requestAnimationFrame(step);
    };
    const replace = (other) => {
      traces = other;
      [slider.min, slider.max] = ends();
      slider.step = (slider.max - slider.min) / (traces.x.length - 1) || "any";
      set(Number(slider.value));
    };
    button.addEventListener("click", toggle);
    slider.addEventListener("input", () => { stop(); set(Number(slider.value)); });
    slider.addEventListener("keydown", (event) => { if (event.key === " ") { toggle(); event.preventDefault(); } });
    [slider.min, slider.max] = ends();
    slider.value = traces.start ?? ends()[0];
    replace(traces);
    return { set, stop, toggle, traces: replace };
  }

  return { mount, show, play };
})();
