"use strict";
const at = id => document.getElementById(id);
const ended = new Set(["done", "interrupted", "failed"]);
const states = {
  reading: "reading the scene", rendering: "rendering", writing: "writing the image", done: "done",
  moving: "the camera moves", interrupted: "interrupted, and saved", failed: "some outputs could not be written"
};
const tone_maps = {none: "none", filmic: "filmic", aces: "ACES", agx: "AgX"};
let run = null, first = 1, last = null, aspect = 0;
let shown = "", shown_number = 0, shown_source = null, loading = false, stale = false;
let follow_until = 0, following = false;
const chosen = {layer: location.hash === "#denoised" ? "denoised" : "", exposure: null, tone_map: null};

function duration(seconds) {
  if (seconds === null || seconds === undefined) return "?";
  if (seconds < 9.95) return (seconds < 0.995 ? seconds.toFixed(2) : seconds.toFixed(1)) + " s";
  const s = Math.round(seconds), minutes = Math.round(seconds / 60), pad = n => String(n).padStart(2, "0");
  if (s < 60) return s + " s";
  if (s < 3600) return Math.floor(s / 60) + " min " + pad(s % 60) + " s";
  return Math.floor(minutes / 60) + " h " + pad(minutes % 60) + " min";
}

function big(n) {
  for (const [size, name] of [[1e9, " G"], [1e6, " M"], [1e3, " k"]])
    if (n >= size) return (n / size).toPrecision(3) + name;
  return String(n);
}

function put(parent, kind, text) {
  const child = document.createElement(kind);
  child.textContent = text;
  parent.append(child);
}

function note(text) {
  at("note").textContent = text;
  at("note").hidden = text === "";
}

function show_figures(status) {
  const report = status.report, figures = [["elapsed", duration(status.elapsed_seconds)]];
  const most = status.total_is_bound ? "at most " : "";
  if (status.state === "rendering") figures.push(["left", most + duration(status.left_seconds)]);
  figures.push(["samples", big(status.done) + " of " + most + big(status.total)]);
  at("summary").textContent = figures.map(figure => figure.join(" ")).join(" \u00b7 ");
  if (status.samples_per_second > 0) figures.push(["per second", big(Math.round(status.samples_per_second))]);
  if (report) {
    figures.push(["size", report.width + " \u00d7 " + report.height], ["integrator", report.integrator],
      ["samples per pixel", ended.has(status.state) || report.mean_samples >= report.spp ? report.spp :
        Number(report.mean_samples.toPrecision(3)) + " of " + report.spp], ["threads", report.threads + ", " + report.isa],
      ["rays per second", big(Math.round(report.rays_per_second))],
      ["in Embree", (100 * report.trace_share).toFixed(1) + " %"],
      ["memory", big(report.peak_rss_bytes) + "B"]);
    if (report.noise !== null) figures.push(["noise", (100 * report.noise).toFixed(2) + " %"]);
    if (report.adaptive) figures.push(["tiles done", report.adaptive.tiles_reached + " of " + report.adaptive.tiles]);
    if (report.dropped.samples + report.dropped.rays > 0)
      figures.push(["dropped", report.dropped.rays + " rays, " + report.dropped.samples + " samples"]);
  }
  at("figures").replaceChildren();
  for (const [name, value] of figures) {
    const figure = document.createElement("div");
    put(figure, "span", name + " ");
    put(figure, "b", value);
    at("figures").append(figure);
  }
}

function show_stages(report) {
  const table = at("stages");
  table.replaceChildren();
  const head = document.createElement("tr");
  for (const name of ["stage", "items", "calls", "seconds", "ns/item", "lane fill"]) put(head, "th", name);
  table.append(head);
  for (const stage of report.stages) {
    if (stage.items === 0) continue;
    const row = document.createElement("tr");
    put(row, "td", stage.name);
    for (const value of [big(stage.items), big(stage.calls), stage.seconds.toFixed(3), stage.ns_per_item.toFixed(1),
      (100 * stage.lane_fill).toFixed(1) + " %"]) put(row, "td", value);
    table.append(row);
  }
}

function show_log(messages) {
  const log = at("log"), text = messages.join("\n");
  if (log.textContent !== text) log.textContent = text;
}

// The errors of the scene, with their file and line in bold.
function show_errors(text) {
  const errors = at("errors");
  errors.hidden = text === "";
  if (errors.dataset.text === text) return;
  errors.dataset.text = text;
  errors.replaceChildren();
  for (const line of text.split("\n")) {
    const place = /^.+?:\d+: /.exec(line), row = document.createElement("div");
    if (place) put(row, "b", place[0]);
    row.append(line.slice(place ? place[0].length : 0));
    errors.append(row);
  }
}

function show_camera(camera) {
  at("camera_button").hidden = !camera;
  if (!camera) {
    delete document.body.dataset.camera;
    return;
  }
  document.body.dataset.camera = camera.number;
  document.body.dataset.moved = camera.moved;
  last.camera = camera;
  const field = at("look_at"), text = camera[at("dialect").value];
  if (field.value !== text) field.value = text;
}

function show_choices(status) {
  const layers = ["", "denoised", ...status.layers], select = at("layer");
  if (select.options.length !== layers.length) {
    select.replaceChildren(...layers.map(name => new Option(name || "image", name)));
    if (!layers.includes(chosen.layer)) chosen.layer = "";
  }
  select.value = chosen.layer;
  at("tone").value = chosen.tone_map ?? status.tone_map;
  const stops = chosen.exposure ?? status.exposure;
  at("exposure").value = stops ?? 0;
  at("stops").value = stops === null ? "auto" : (stops > 0 ? "+" : "") + Number(stops).toFixed(1);
}

// Fits the image into the view. While the camera moves, small images take the same place.
function place() {
  const view = at("view"), image = at("image"), whole = view.classList.contains("whole");
  const width = whole ? image.naturalWidth : Math.min(view.clientWidth, view.clientHeight * aspect);
  const height = whole ? image.naturalHeight : width / (aspect || 1);
  image.style.width = width + "px";
  image.style.height = height + "px";
  image.style.left = Math.max(0, (view.clientWidth - width) / 2) + "px";
  image.style.top = Math.max(0, (view.clientHeight - height) / 2) + "px";
}

// The source of the image that is wanted, and the number of the last one.
function wanted() {
  const moves = performance.now() < follow_until;
  const denoised = chosen.layer === "denoised" && !moves && last.denoised_image >= first;
  const layer = chosen.layer === "denoised" ? "" : chosen.layer, query = new URLSearchParams();
  if (layer) query.set("layer", layer);
  if (chosen.exposure !== null) query.set("exposure", chosen.exposure);
  if (chosen.tone_map !== null) query.set("tone_map", chosen.tone_map);
  return {path: (denoised ? "denoised/" : "") + "image.png", query, denoised,
    number: denoised ? last.denoised_image : layer ? last.layers_image : last.image};
}

// Loads an image; the previous one stays visible until then. Returns whether there was another one.
async function load(source, after) {
  const query = new URLSearchParams(source.query);
  if (after) query.set("after", after);
  const answer = await fetch(source.path + "?" + query, {cache: "no-store", signal: AbortSignal.timeout(8000)});
  if (answer.status !== 200) return false;
  const number = Number(answer.headers.get("Sheaf-Image"));
  const url = URL.createObjectURL(await answer.blob()), next = new Image();
  next.src = url;
  await next.decode();
  const image = at("image"), before = image.src;
  image.src = url;
  if (before.startsWith("blob:")) URL.revokeObjectURL(before);
  image.dataset.number = number;
  image.dataset.denoised = source.denoised;
  image.dataset.layer = chosen.layer;
  image.hidden = false;
  at("none").hidden = true;
  if (performance.now() >= follow_until || !aspect) aspect = next.naturalWidth / next.naturalHeight;
  shown_number = number;
  shown_source = source.path + "?" + source.query;
  place();
  return true;
}

async function load_image() {
  if (!last || following) return;
  const source = wanted(), key = [run, source.path, source.query, source.number].join(" ");
  if (source.number < first || key === shown) return;
  if (loading) {
    stale = true;
    return;
  }
  loading = true;
  try {
    if (await load(source, 0)) shown = key;
  } catch (error) {
    // the next status shows whether the program has ended
  }
  loading = false;
  if (stale) {
    stale = false;
    load_image();
  }
}

function show(status) {
  // The last image of another render stays visible until this one has an image
  if (status.run !== run) {
    first = run === null ? 1 : status.image + 1;
    if (last && status.image < last.image) first = 1;  // of another program
    run = status.run;
  }
  last = status;
  at("scene").textContent = status.scene;
  at("state").textContent = status.errors ? "the scene has errors" : states[status.state] || status.state;
  at("bar").value = status.fraction;
  document.title = Math.floor(100 * status.fraction) + " % " + status.scene;
  document.body.dataset.state = status.state;
  note(!ended.has(status.state) || status.errors ? "" : status.repeats ? "Waiting for changes of the scene." :
    "The render has ended. This page stays as it is.");
  show_errors(status.errors);
  show_camera(status.camera);
  show_choices(status);
  show_figures(status);
  if (status.report) show_stages(status.report);
  show_log(status.messages);
  load_image();
}

async function look() {
  try {
    const folder = chosen.layer === "denoised" ? "denoised/" : "";
    const answer = await fetch(folder + "status.json", {cache: "no-store", signal: AbortSignal.timeout(8000)});
    if (!answer.ok) throw new Error(answer.status);
    show(await answer.json());
    // Another browser may move the camera
    if (last.state === "moving") follow();
  } catch (error) {
    if (!last || last.repeats || !ended.has(last.state)) note("The render does not answer. Has the program ended?");
  }
  setTimeout(look, 1000);
}

// Shows the images of a moving camera one after the other, until it has rested for a while.
async function follow() {
  follow_until = performance.now() + 1000;
  if (following) return;
  following = true;
  try {
    while (performance.now() < follow_until) {
      const source = wanted();
      const after = shown_source === source.path + "?" + source.query ? shown_number : 0;
      if (!await load(source, after)) await new Promise(done => setTimeout(done, 12));
    }
  } catch (error) {
    // the next status shows whether the program has ended
  }
  following = false;
  shown = "";
  first = Math.max(first, shown_number);  // older images show another place
}

// Motions are collected while the last request is under way.
let motion = {}, sending = false;

function move(change) {
  for (const name of ["orbit", "pan"])
    if (change[name]) motion[name] = change[name].map((value, i) => value + (motion[name] ? motion[name][i] : 0));
  if (change.dolly) motion.dolly = change.dolly + (motion.dolly || 0);
  for (const name of ["reset", "target", "focus"]) if (change[name]) motion[name] = change[name];
  send();
}

async function send() {
  if (sending || Object.keys(motion).length === 0 || !last || !last.camera) return;
  sending = true;
  const body = JSON.stringify(motion);
  motion = {};
  try {
    const answer = await fetch("camera", {method: "POST", body, headers: {"Content-Type": "application/json"}});
    if (answer.ok) {
      show_camera(await answer.json());
      follow();
    }
  } catch (error) {
    note("The render does not answer. Has the program ended?");
  }
  sending = false;
  send();
}

// Position of the pointer on the image, from (0, 0) to (1, 1); null beside it.
function position_of(event) {
  const box = at("image").getBoundingClientRect();
  const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
  return x >= 0 && x <= 1 && y >= 0 && y <= 1 ? [x, y] : null;
}

const digits = (values, count) => values.map(value => Number(value).toPrecision(count)).join("  ");

async function pick(position) {
  try {
    const answer = await fetch("pick.json?x=" + position[0].toFixed(5) + "&y=" + position[1].toFixed(5));
    if (!answer.ok) return;
    const point = await answer.json(), lines = [];
    if (point.object === undefined) lines.push("no surface");
    else lines.push("object    " + point.object, "material  " + point.material,
      "position  " + digits(point.position, 6), "distance  " + Number(point.distance).toPrecision(6));
    if (point.radiance) lines.push("radiance  " + digits(point.radiance, 4), "pixel     " + point.pixel.join("  "));
    at("pick").textContent = lines.join("\n");
    at("pick").hidden = false;
  } catch (error) {
    // the next status shows whether the program has ended
  }
}

// One pointer orbits or pans, two pinch and pan. A pointer that does not move clicks.
const pointers = new Map();
let press = null, last_click = null;

function on_down(event) {
  if (event.target.closest("#errors, #pick") || !last || !last.camera) return;
  at("view").setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  press = pointers.size === 1 ? {x: event.clientX, y: event.clientY, moved: false} : {moved: true};
  at("view").classList.add("dragging");
}

function on_move(event) {
  const from = pointers.get(event.pointerId);
  if (!from) return;
  const to = [event.clientX, event.clientY], height = at("image").getBoundingClientRect().height || 1;
  if (!press.moved && Math.hypot(to[0] - press.x, to[1] - press.y) < 5) return;
  press.moved = true;
  const delta = [(to[0] - from[0]) / height, (to[1] - from[1]) / height];
  pointers.set(event.pointerId, to);
  if (pointers.size === 1) {
    const pans = event.shiftKey || (event.buttons & 6) !== 0;
    move(pans ? {pan: delta} : {orbit: delta});
  } else if (pointers.size === 2) {
    const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
    const apart = p => Math.max(Math.hypot(p[0] - other[0], p[1] - other[1]), 1);
    move({pan: [delta[0] / 2, delta[1] / 2], dolly: Math.log2(apart(from) / apart(to))});
  }
}

function on_up(event) {
  if (!pointers.delete(event.pointerId)) return;
  if (pointers.size > 0) return;
  at("view").classList.remove("dragging");
  const position = position_of(event);
  if (press.moved || event.type === "pointercancel" || event.button > 0 || !position) return;
  const now = {time: event.timeStamp, x: event.clientX, y: event.clientY};
  const twice = last_click && now.time - last_click.time < 400 &&
    Math.hypot(now.x - last_click.x, now.y - last_click.y) < 12;
  last_click = twice ? null : now;
  if (twice) move(event.altKey ? {focus: position} : {target: position});
  else pick(position);
}

function on_wheel(event) {
  if (!last || !last.camera || event.target.closest("#errors, #pick")) return;
  event.preventDefault();
  const lines = event.deltaMode === 1 ? 30 : event.deltaMode === 2 ? 400 : 1;
  move({dolly: Math.max(-2, Math.min(2, event.deltaY * lines / 500))});
}

function on_key(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("textarea, select, input")) return;
  if (event.key === "r" || event.key === "R") move({reset: true});
  if (event.key === "Escape") at("pick").hidden = true;
}

async function copy() {
  const field = at("look_at");
  try {
    await navigator.clipboard.writeText(field.value);
  } catch (error) {  // only secure pages may use the clipboard directly
    field.select();
    document.execCommand("copy");
  }
  at("copy").textContent = "copied";
  setTimeout(() => { at("copy").textContent = "copy"; }, 1500);
}

function toggle(button, panel) {
  at(panel).hidden = !at(panel).hidden;
  at(button).setAttribute("aria-expanded", !at(panel).hidden);
  place();
}

function toggle_whole() {
  const whole = at("view").classList.toggle("whole");
  at("whole").setAttribute("aria-pressed", whole);
  place();
}

for (const [name, title] of Object.entries(tone_maps)) at("tone").append(new Option(title, name));
const changed = () => {
  if (!last) return;
  show_choices(last);
  load_image();
};
at("layer").onchange = () => { chosen.layer = at("layer").value; changed(); };
at("tone").onchange = () => { chosen.tone_map = at("tone").value; changed(); };
at("exposure").oninput = () => { chosen.exposure = Number(at("exposure").value); changed(); };
at("stops").ondblclick = () => { chosen.exposure = null; changed(); };
at("dialect").onchange = () => { if (last) show_camera(last.camera); };
at("copy").onclick = copy;
at("reset").onclick = () => move({reset: true});
at("whole").onclick = toggle_whole;
at("camera_button").onclick = () => toggle("camera_button", "camera");
at("details_button").onclick = () => toggle("details_button", "details");
at("image").onclick = () => { if (last && !last.camera) toggle_whole(); };
for (const [name, handle] of [["pointerdown", on_down], ["pointermove", on_move], ["pointerup", on_up],
  ["pointercancel", on_up]]) at("view").addEventListener(name, handle);
at("view").addEventListener("wheel", on_wheel, {passive: false});
at("view").addEventListener("contextmenu", event => { if (last && last.camera) event.preventDefault(); });
addEventListener("keydown", on_key);
addEventListener("resize", place);
new ResizeObserver(place).observe(at("view"));
look();
