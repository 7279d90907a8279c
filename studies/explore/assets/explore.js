"use strict";
/* The live page: sliders send what they show, one request in flight and the newest kept; answers are drawn as they come.

   An answer is a length of 4 bytes, a header as JSON, and curves as numbers of 4 bytes, see frames.py. Each bears the number
   of its request; the exact one follows once no other request has come for a moment. */
const apesimExplore = (() => {
  const MEGA = 1e6, MILLI = 1e3;
  const RECONNECT_MS = 1000;
  const HEIGHT = 230;  // of a chart [px]
  const COLOURS = { own: { colour: 0, dash: 0, marker: null }, ideal: { colour: 2, dash: 1, marker: null } };
  const EXHAUST = "exhaust air";
  const FACTS = [
    ["brake_torque_Nm", "brake torque", 1, "N m", 2], ["brake_power_W", "brake power", 1e-3, "kW", 2],
    ["air_L_per_min_ANR", "all air, ANR", 1, "L/min", 0], ["specific_air_kg_per_kWh", "air over brake work", 1, "kg/kWh", 1],
    ["exergy_efficiency", "exergy efficiency", 100, "%", 1], ["valve_open_deg", "opens at", 1, "°", 1],
    ["valve_close_deg", "closes at", 1, "°", 1], ["peak_lift_m", "peak lift", MILLI, "mm", 2],
    ["opening_seating_speed_m_s", "seating speed, opening", 1, "m/s", 2], ["closing_seating_speed_m_s", "seating speed, closing", 1, "m/s", 2],
    ["peak_cylinder_pressure_Pa", "peak pressure, abs", 1 / MEGA, "MPa", 3], ["exhaust_temperature_K", EXHAUST, 1, "K", 0],
  ];
  const $ = (id) => document.getElementById(id);
  const values = new Map();  // texts by key, of what was moved
  const rows = new Map();  // parts of the page by key of a slider
  let start = null, socket = null, charts = null, picture = null, player = null;
  let number = 0, shown = 0, isInFlight = false, isWaiting = false, movedAt = null, sentFor = null, isFollowing = false, overlay = null;

  function make(tag, attributes = {}, text = "") {
    const node = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text) node.textContent = text;
    return node;
  }

  const request = () => JSON.stringify({ number, values: { speed: textOf(start.sliders[0]), ...Object.fromEntries(values) } });
  const textOf = (slider) => slider.unit ? `${slider.value} ${slider.unit}` : String(slider.value);

  // --- one request in flight, the newest kept

  function connect() {
    socket = new WebSocket(`ws://${location.host}/session`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { isInFlight = false; ask(); };
    socket.onmessage = (event) => take(decode(event.data));
    socket.onclose = () => {
      isInFlight = false;
      tell("bad", "the server has ended: start apesim explore again");
      setTimeout(connect, RECONNECT_MS);
    };
  }

  function ask(at = performance.now()) {
    isWaiting = true;
    movedAt ??= at;
    pump();
  }

  function pump() {
    if (isInFlight || !isWaiting || socket?.readyState !== WebSocket.OPEN) return;
    [isInFlight, isWaiting, sentFor, movedAt] = [true, false, movedAt, null];
    number += 1;
    socket.send(request());
  }

  function decode(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    let offset = 4 + length;
    const curves = {};
    for (const [name, count] of header.curves) {
      curves[name] = new Float32Array(buffer, offset, count);
      offset += 4 * count;
    }
    return { header, curves };
  }

  function take({ header, curves }) {
    if (header.kind === "compiling") return tell("wait", header.text);
    const isOld = header.number < shown || (header.is_exact && (header.number !== number || isWaiting));
    const moved = sentFor;
    if (!header.is_exact) [isInFlight, sentFor] = [false, null];
    if (!isOld) {
      requestAnimationFrame(() => {
        shown = header.number;
        if (header.kind === "refused") refuse(header.faults);
        else draw(header, curves);
        if (moved !== null && !header.is_exact) {  // the frame is painted before the next task
          const channel = new MessageChannel();
          channel.port1.onmessage = () => performance.measure("apesim:moved-to-painted", { start: moved, end: performance.now(), detail: { number: header.number, server: header.server_ms, processor: header.processor_ms } });
          channel.port2.postMessage(null);
        }
      });
    }
    pump();
  }

  function tell(state, text) {
    $("status").dataset.state = state;
    $("status-text").textContent = text;
  }

  // --- what an answer shows

  function draw(header, curves) {
    clearFaults();
    document.body.classList.remove("stale");
    warn(header.warnings);
    $("conditions").textContent = `${rows.get("speed").entry.value} r/min, supply ${header.conditions}`;
    showFacts(header.own, header.ideal);
    facts.at(-1)[2].textContent = header.is_adiabatic ? `${EXHAUST}, adiabatic` : EXHAUST;
    const hasCurves = curves.lift !== undefined;
    if (hasCurves) showCurves(curves);
    if (header.picture) mountPicture(header.picture, curves);
    else if (player && hasCurves) player.traces(tracesOf(curves));
    if (!hasCurves) document.body.classList.add("stale");
    const state = header.own.converged === 1 ? "" : ", not periodic";
    if (header.is_exact) tell(state || !hasCurves ? "bad" : "exact", `exact, as engine run gives it${state}`);
    else tell("quick", `live, ${header.server_ms.toFixed(0)} ms${state}`);
    if (header.is_exact) history.replaceState(null, "", values.size ? `#${new URLSearchParams([...values])}` : location.pathname);
  }

  const isNumber = (value) => typeof value === "number" && Number.isFinite(value);
  const minus = (text) => text.replace("-", "−");

  function showFacts(own, ideal) {
    FACTS.forEach(([name, , factor, unit, digits], i) => {
      const [value, place] = facts[i], mine = own[name], other = ideal[name];
      value.firstChild.data = isNumber(mine) ? minus((mine * factor).toFixed(digits)) : "–";
      const has = start.intake !== "ideal" && isNumber(other);
      place.textContent = has ? `ideal ${minus((other * factor).toFixed(digits))}` : "\u00a0";
    });
  }
  let facts = [];

  function buildFacts() {
    facts = FACTS.map(([, label, , unit]) => {
      const item = make("li"), value = make("b", {}, "–"), ideal = make("span", { class: "ideal" }, "\u00a0");
      value.append(make("small", {}, ` ${unit}`));
      const name = make("span", {}, label);
      item.append(name, value, ideal);
      $("facts").append(item);
      return [value, ideal, name];
    });
  }

  const scaled = (curve, factor) => Float64Array.from(curve, (each) => each * factor);
  const PAIRS = { lift: ["lift", MILLI], torque: ["torque", 1], flow: ["groove_flow", MILLI], temperature: ["cylinder_temperature", 1] };
  const PRESSURES = [["cylinder", "cylinder_pressure"], ["receiver", "receiver_pressure"], ["chamber A", "pressure_a"], ["chamber B", "pressure_b"], ["cylinder, ideal valve", "ideal_cylinder_pressure"]];
  const OVERLAID = { lift: [["lift", MILLI]], pressures: [["cylinder_pressure", 1 / MEGA], ["pressure_a", 1 / MEGA], ["pressure_b", 1 / MEGA], ["receiver_pressure", 1 / MEGA]] };

  function showCurves(curves) {
    const hasIdeal = start.intake !== "ideal", sets = {};
    for (const [id, [name, factor]] of Object.entries(PAIRS)) {
      sets[id] = [scaled(curves[name], factor), ...(hasIdeal ? [scaled(curves[`ideal_${name}`], factor)] : [])];
    }
    sets.pressures = pressuresShown(curves).map(([, name]) => scaled(curves[name], 1 / MEGA));
    const loops = [[curves.cylinder_volume, curves.cylinder_pressure], ...(hasIdeal ? [[curves.ideal_cylinder_volume, curves.ideal_cylinder_pressure]] : [])]
      .map(([x, y]) => ({ x: scaled(x, MEGA), values: scaled(y, 1 / MEGA) }));
    if (!charts) return buildCharts(curves, sets, loops);
    for (const id of Object.keys(sets)) apesimCurves.update(charts[id], { series: sets[id] });
    apesimCurves.update(charts.loop, { series: loops });
  }

  // Chambers have a pressure where the intake is an electro-pneumatic valve.
  const pressuresShown = (curves) => PRESSURES.filter(([, name]) => curves[name].some(Number.isFinite) && (start.intake !== "ideal" || !name.startsWith("ideal")));

  function buildCharts(curves, sets, loops) {
    const x = { label: "crank angle", unit: "deg", values: start.angles };
    const name = start.intake === "epv" ? "EPV" : start.intake === "cam" ? "cam" : "ideal valve";
    const pair = [{ label: name, ...COLOURS.own }, { label: "ideal valve", ...COLOURS.ideal }];
    const measured = (id) => (overlay ? OVERLAID[id] ?? [] : []).filter(([channel]) => overlay.curves[channel]).map(([channel, factor]) => {
      const points = overlay.curves[channel], at = PRESSURES.findIndex(([, each]) => each === channel);
      return { label: `measured ${channel.replaceAll("_", " ")}`, x: points.x, values: points.values.map((value) => value * factor), line: false, marker: Math.max(at, 0), colour: at < 0 ? 3 : PRESSURE_LOOKS[at].colour };
    });
    const one = (id, label, unit) => apesimCurves.draw($(id), { x, y: { label, unit }, sync: "angle", height: HEIGHT, series: [...sets[id].map((each, i) => ({ ...pair[i], values: each })), ...measured(id)] });
    charts = {
      loop: apesimCurves.drawLoops($("loop"), { height: HEIGHT, x: { label: "volume", unit: "cm³" }, y: { label: "cylinder pressure", unit: "MPa abs" }, series: loops.map((each, i) => ({ ...pair[i], ...each })) }),
      lift: one("lift", "lift", "mm"),
      pressures: apesimCurves.draw($("pressures"), { x, y: { label: "pressure", unit: "MPa abs" }, sync: "angle", height: HEIGHT,
        series: [...pressuresShown(curves).map(([label, each], i) => ({ label, ...PRESSURE_LOOKS[PRESSURES.findIndex(([, other]) => other === each)], values: sets.pressures[i] })), ...measured("pressures")] }),
      torque: one("torque", "indicated torque", "N m"),
      flow: one("flow", "air flow", "g/s"),
      temperature: one("temperature", "cylinder temperature", "K"),
    };
    for (const id of ["lift", "pressures", "torque", "flow", "temperature"]) charts[id].onMove = (angle) => { if (!isFollowing) player?.set(angle); };
  }
  const PRESSURE_LOOKS = [0, 3, 1, 4, 2].map((colour, i) => ({ colour, dash: [0, 4, 2, 3, 1][i], marker: null }));

  function rebuildCharts(curves) {
    if (charts) Object.values(charts).forEach((chart) => apesimCurves.remove(chart));
    charts = null;
    if (curves) showCurves(curves);
  }

  // --- the picture that moves

  const tracesOf = (curves) => ({
    label: "crank angle", unit: "°", period: 360, start: picture?.at ?? 60, x: start.angles,
    lift: curves.lift, pA: curves.pressure_a, pB: curves.pressure_b, pCylinder: curves.cylinder_pressure, pReceiver: curves.receiver_pressure,
  });

  function mountPicture({ html, geometry }, curves) {
    const wasPlaying = picture?.isPlaying() ?? false;
    player?.stop();
    $("motion").innerHTML = html;
    const traces = tracesOf(curves), handle = apesimMotion.mount($("motion"), geometry);
    const button = $("motion").querySelector(".motion-play");
    picture = { at: traces.start, isPlaying: () => button.getAttribute("aria-pressed") === "true" };
    const own = picture;
    player = apesimMotion.play(handle, traces, (angle) => {
      own.at = angle;
      if (!own.isPlaying()) return;
      isFollowing = true;
      charts?.lift.move(Math.round(angle - start.angles[0]));
      isFollowing = false;
    });
    if (wasPlaying) player.toggle();
  }

  // --- what cannot be, and what to know

  function warn(texts, title = "To know") {
    const box = $("warnings");
    const content = texts.join("\n");
    if (box.dataset.content === content) return;
    box.dataset.content = content;
    box.hidden = texts.length === 0;
    box.replaceChildren(...texts.map((text) => { const line = make("p", {}, ""); line.append(make("strong", {}, `${title}: `), text); return line; }));
  }

  function refuse(faults) {
    clearFaults();
    document.body.classList.add("stale");
    warn(faults.map(({ key, wrong, right }) => `${nameOf(key)} ${wrong}; ${right}`), "Not run");
    tell("bad", "not run: see the marked value");
    for (const { key, wrong, right } of faults) {
      const row = rows.get(key);
      if (!row) continue;
      row.box.classList.add("bad");
      row.entry.setAttribute("aria-invalid", "true");
      row.box.append(make("p", { class: "fault" }, `${wrong}; ${right}`));
    }
  }
  const nameOf = (key) => rows.get(key)?.slider.label ?? key;

  function clearFaults() {
    for (const { box, entry } of rows.values()) {
      if (!box.classList.contains("bad")) continue;
      box.classList.remove("bad");
      entry.removeAttribute("aria-invalid");
      box.querySelectorAll(".fault").forEach((node) => node.remove());
    }
  }

  // --- sliders

  const short = (value) => String(Number(Number(value).toPrecision(10)));

  const shownAs = (slider) => slider.note || short(slider.value);

  function buildSlider(slider, parent) {
    const id = `slider-${slider.key.replaceAll(".", "-")}`;
    const box = make("div", { class: "slider" }), row = make("div", { class: "row" });
    const label = make("label", { for: id }, slider.label);
    const entry = make("input", { class: "entry", type: "text", value: shownAs(slider), "aria-label": `${slider.label}, with or without its unit ${slider.unit}`, spellcheck: "false", autocomplete: "off" });
    const undo = make("button", { type: "button", class: "undo", title: "as the machine has it", "aria-label": `${slider.label}: as the machine has it` }, "↺");
    const range = make("input", { id, type: "range", min: slider.low, max: slider.high, step: "any", value: slider.value });
    row.append(label, entry, make("span", { class: "unit" }, slider.unit.replace("^2", "²").replace("^3", "³")), undo);
    entry.classList.toggle("noted", Boolean(slider.note));
    box.append(row, range);
    parent.append(box);
    const own = { slider, box, entry, range };
    rows.set(slider.key, own);
    own.range.addEventListener("input", (event) => {
      const text = short(Math.round(range.value / slider.step) * slider.step);
      entry.value = text;
      put(own, slider.unit ? `${text} ${slider.unit}` : text, event.timeStamp);
    });
    range.addEventListener("keydown", (event) => {
      const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (steps === undefined) return;
      event.preventDefault();
      range.value = (Math.round(range.value / slider.step) + steps) * slider.step;
      range.dispatchEvent(new Event("input"));
    });
    entry.addEventListener("change", (event) => {
      const text = entry.value.trim();
      if (!text) return clear(own);
      const isBare = text !== "" && Number.isFinite(Number(text));
      if (isBare) range.value = text;
      put(own, isBare && slider.unit ? `${text} ${slider.unit}` : text, event.timeStamp);
    });
    undo.addEventListener("click", () => clear(own));
  }

  function put(row, text, at) {
    values.set(row.slider.key, text);
    row.box.classList.add("moved");
    row.entry.classList.remove("noted");
    $("reset").disabled = false;
    ask(at);
  }

  function clear(row) {
    if (row.isOfEffect) return row.range.dispatchEvent(new Event("input"));
    values.delete(row.slider.key);
    row.box.classList.remove("moved");
    row.entry.value = shownAs(row.slider);
    row.entry.classList.toggle("noted", Boolean(row.slider.note));
    row.range.value = row.slider.value;
    $("reset").disabled = values.size === 0;
    ask();
  }

  // Values from the address of the page, or of a measured run: what has no slider is left out.
  function putAll(pairs) {
    for (const [key, text] of pairs) {
      const effect = start.effects.find(({ name }) => key.startsWith(`effects.${name}.`));
      if (effect && !rows.has(key)) switchOn(effect);
      const row = rows.get(key);
      if (!row) continue;
      const [figure, ...unit] = text.split(" "), same = unit.join(" ") === row.slider.unit;
      row.entry.value = same ? figure : text;
      if (same) row.range.value = figure;
      values.set(key, text);
      row.box.classList.add("moved");
    }
    $("reset").disabled = values.size === 0;
    ask();
  }

  function buildSliders() {
    const groups = new Map();
    for (const slider of start.sliders) {
      if (!groups.has(slider.group)) {
        const group = make("details");
        group.open = groups.size < 2 || matchMedia("(min-width: 46rem)").matches;
        group.append(make("summary", {}, slider.group));
        groups.set(slider.group, group);
        $("sliders").append(group);
      }
      buildSlider(slider, groups.get(slider.group));
    }
    if (start.can_correct) buildCorrection(groups.get("Timing"));
    buildEffects();
    if (start.measured.length) buildMeasured();
  }

  // The commands with which the real valve opens and closes where the ideal one does, at the speed that is shown.
  function buildCorrection(group) {
    const button = make("button", { type: "button", id: "correct", title: "sets energise and release" }, "Open and close as the ideal valve");
    button.addEventListener("click", async () => {
      const text = button.textContent;
      [button.disabled, button.textContent] = [true, "Finding the commands …"];
      const answer = await post("/timing");
      [button.disabled, button.textContent] = [false, text];
      if (answer) putAll(Object.entries((await answer.json()).values));
    });
    group.querySelector("summary").after(button);
  }

  function buildEffects() {
    const group = make("details"), select = make("select", { "aria-label": "switch an effect on" });
    group.id = "effects";
    group.append(make("summary", {}, "Effects"), make("p", { class: "soft" }, "Physics that the machine has not. With the first one a march is compiled, once."), select);
    select.append(make("option", { value: "" }, "switch an effect on …"));
    for (const effect of start.effects) {
      if (effect.is_on) continue;
      const option = make("option", { value: effect.name }, effect.name.replaceAll("_", " "));
      select.append(option);
    }
    select.addEventListener("change", () => {
      const effect = start.effects.find(({ name }) => name === select.value);
      select.value = "";
      if (effect) switchOn(effect);
    });
    $("sliders").append(group);
    start.effects.filter(({ is_on }) => is_on).forEach((effect) => addEffect(effect));
    if (start.effects.some(({ is_on }) => is_on)) group.open = true;
  }

  function addEffect(effect) {
    const box = make("div", { class: "effect" }), row = make("div", { class: "row" });
    row.append(make("span", {}, effect.name.replaceAll("_", " ")));
    box.append(row, make("p", { class: "soft" }, `seen in: ${effect.seen_in}`));
    $("effects").append(box);
    effect.sliders.forEach((slider) => buildSlider(slider, box));
    return [box, row];
  }

  function switchOn(effect) {
    if (rows.has(effect.sliders[0].key)) return;
    const [box, row] = addEffect(effect);
    const off = make("button", { type: "button" }, "switch off");
    row.append(off);
    $("effects").open = true;
    for (const slider of effect.sliders) values.set(slider.key, textOf(slider));
    const option = $("effects").querySelector(`option[value="${effect.name}"]`);
    option.disabled = true;
    off.addEventListener("click", () => {
      for (const { key } of effect.sliders) { values.delete(key); rows.delete(key); }
      box.remove();
      option.disabled = false;
      $("reset").disabled = values.size === 0;
      ask();
    });
    $("reset").disabled = false;
    ask();
  }

  function buildMeasured() {
    const group = make("details", { class: "measured" }), select = make("select", { "aria-label": "measured run" }), note = make("p", { class: "soft" });
    const go = make("button", { type: "button" }, "Set sliders to this run");
    group.open = true;
    group.append(make("summary", {}, "Measured"), select, go, note);
    select.append(make("option", { value: "" }, "no run"));
    start.measured.forEach((run, i) => select.append(make("option", { value: i }, `${run.name}, ${run.values.speed.replace(" rpm", " r/min")}`)));
    const choose = () => {
      overlay = start.measured[select.value] ?? null;
      go.disabled = !overlay;
      const means = Object.entries(overlay?.means ?? {}).map(([name, value]) => name === "torque" ? `brake torque ${apesimCurves.format(value)} N m` : `air flow ${apesimCurves.format(value * MILLI)} g/s`);
      note.textContent = overlay ? `measured: ${means.join(", ") || "curves alone"}` : "";
      rebuildCharts(null);
      ask();
    };
    select.addEventListener("change", choose);
    go.addEventListener("click", () => putAll(Object.entries(overlay.values)));
    $("sliders").prepend(group);
    select.value = 0;
    choose();
  }

  // --- what the page hands on

  async function post(path) {
    const answer = await fetch(path, { method: "POST", body: request(), headers: { "content-type": "application/json" } });
    if (answer.ok) return answer;
    const { faults } = await answer.json();
    refuse(faults);
    return null;
  }

  async function save() {
    const answer = await post("/machine.toml");
    if (!answer) return;
    const link = make("a", { download: "mine.toml", href: URL.createObjectURL(await answer.blob()) });
    link.click();
    URL.revokeObjectURL(link.href);
    flash("save", "Saved: mine.toml");
  }

  async function copy() {
    const answer = await post("/command");
    if (!answer) return;
    const { command, file } = await answer.json(), place = $("command");
    const done = file ? `Copied: save ${file} first` : "Copied";
    place.value = command;
    place.hidden = false;
    try {
      await navigator.clipboard.writeText(command);
      flash("copy", done);
    } catch {  // not allowed: the text is there to be taken
      place.select();
    }
  }

  // A tab is opened at once, as browsers allow it on a click alone; the report comes into it when it is there.
  async function report() {
    const button = $("report"), text = button.textContent, tab = open("about:blank", "_blank");
    [button.disabled, button.textContent] = [true, "Writing …"];
    try {
      const answer = await post("/report");
      if (!answer) return tab?.close();
      const { address } = await answer.json();
      if (tab) tab.location = address;
      else location.assign(address);
    } finally {
      [button.disabled, button.textContent] = [false, text];
    }
  }

  function flash(id, text) {
    const button = $(id), before = button.dataset.text ??= button.textContent;
    button.textContent = text;
    setTimeout(() => { button.textContent = before; }, 1800);
  }

  function reset() {
    document.querySelectorAll(".effect button:not(.undo)").forEach((off) => off.click());
    for (const row of rows.values()) if (row.box.classList.contains("moved")) clear(row);
  }

  async function begin() {
    start = await (await fetch("/start.json")).json();
    buildFacts();
    buildSliders();
    $("shown").textContent = start.shown;
    $("shown").hidden = !start.shown;
    for (const [id, action] of Object.entries({ save, copy, report, reset })) $(id).addEventListener("click", action);
    const given = [...new URLSearchParams(location.hash.slice(1))];
    if (given.length) putAll(given);
    const head = document.querySelector(".top");
    new ResizeObserver(() => document.body.style.setProperty("--head", `${head.offsetHeight}px`)).observe(head);
    connect();
  }

  begin();
  return { state: () => ({ number, shown, isInFlight, isWaiting, status: $("status").dataset.state }) };
})();
