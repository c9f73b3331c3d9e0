"use strict";
// The player of a report: draws the run at a moment, and its figures over time.
(async () => {
  const root = document.querySelector(".player");
  if (!root) return;
  const run = JSON.parse(document.getElementById("run").textContent);
  const TYPES = { u8: Uint8Array, u16: Uint16Array, i16: Int16Array, u32: Uint32Array, f32: Float32Array };

  // Lists of numbers are base64 of zlib of little-endian numbers.
  const unpack = async ({ kind, data }) => {
    const packed = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new TYPES[kind](await new Response(stream).arrayBuffer());
  };
  const unpackAll = async (value) => {
    if (value === null || typeof value !== "object") return value;
    if ("kind" in value && "data" in value) return unpack(value);
    const entries = await Promise.all(Object.entries(value).map(async ([k, v]) => [k, await unpackAll(v)]));
    return Array.isArray(value) ? entries.map(([, v]) => v) : Object.fromEntries(entries);
  };
  const starts = (list) => {
    if (!list) return list;
    list.starts = new Uint32Array(list.counts.length + 1);
    list.counts.forEach((count, k) => { list.starts[k + 1] = list.starts[k] + count; });
    return list;
  };
  try {
    Object.assign(run, await unpackAll(run));
  } catch (error) {
    root.textContent = `This browser cannot unpack the run (${error.message}); the figures below show it.`;
    return;
  }
  starts(run.scan); starts(run.sights);
  for (const method of run.methods) {
    starts(method.particles); starts(method.weighed); starts(method.hypotheses);
  }

  const $ = (selector) => root.querySelector(selector);
  const scene = $(".scene"), slider = $("#time"), playButton = $("#play"), clock = $("#clock");
  const speed = $("#speed"), focusSelect = $("#focus"), now = $(".now");
  const count = run.stamps.length, end = run.stamps[count - 1];
  const state = { frame: 0, time: run.stamps[0], playing: false, focus: run.methods.length - 1, zoom: 1, pan: [0, 0] };
  const layers = {};
  root.querySelectorAll(".layers input").forEach((box) => {
    layers[box.name] = box.checked;
    box.addEventListener("change", () => { layers[box.name] = box.checked; draw(); });
  });

  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  let colors = {};
  const readColors = () => {
    for (const name of ["ink", "muted", "grid", "edge", "paper", "scan", "landmark"]) colors[name] = css(`--${name}`);
    colors.methods = run.methods.map((_, k) => css(`--m${k % 12}`));
  };
  // From the seventh method on, lines have dashes as well.
  const dashes = (m) => [[], [7, 3, 1.5, 3], [10, 4], [7, 3, 1.5, 3, 1.5, 3]][Math.min(3, Math.floor(m / 6))];
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", () => { readColors(); charts.forEach((c) => { c.base = null; }); draw(); });

  let image = null;
  if (run.map) {
    image = new Image();
    image.onload = () => draw();
    image.src = run.map.uri;
  }

  // A canvas as large as its place on the screen; returns its context in CSS pixels.
  const fit = (canvas, height) => {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth;
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const c = canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    return [c, width, height];
  };

  const [left, low, right, high] = run.bounds;
  const aspect = (high - low) / (right - left);
  const view = () => {
    const width = scene.clientWidth;
    const height = Math.min(width * aspect, Math.max(320, window.innerHeight * 0.78));
    scene.style.height = `${height}px`;
    const scale = Math.min(width / (right - left), height / (high - low)) * state.zoom;
    const center = [(left + right) / 2 + state.pan[0], (low + high) / 2 + state.pan[1]];
    return { width, height, scale, x: (x) => width / 2 + (x - center[0]) * scale, y: (y) => height / 2 - (y - center[1]) * scale };
  };

  const path = (c, v, track, from, to) => {
    c.beginPath();
    for (let k = from; k <= to; k++) {
      const x = v.x(track.x[k]), y = v.y(track.y[k]);
      const jump = k > from && Math.hypot(track.x[k] - track.x[k - 1], track.y[k] - track.y[k - 1]) > 2;
      if (k === from || jump) c.moveTo(x, y); else c.lineTo(x, y);
    }
    c.stroke();
  };
  const ellipse = (c, v, x, y, xx, xy, yy) => {
    if (!(xx >= 0) || !(yy >= 0)) return;
    const mean = (xx + yy) / 2, d = Math.hypot((xx - yy) / 2, xy), turn = 0.5 * Math.atan2(2 * xy, xx - yy);
    c.beginPath();
    // Two standard deviations, and never too small to be seen.
    const radius = (value) => Math.max(2.5, 2 * Math.sqrt(Math.max(0, value)) * v.scale);
    c.ellipse(v.x(x), v.y(y), radius(mean + d), radius(mean - d), -turn, 0, 2 * Math.PI);
  };
  const robot = (c, v, x, y, theta, size, fill, stroke) => {
    c.save();
    c.translate(v.x(x), v.y(y)); c.rotate(-theta);
    c.beginPath(); c.moveTo(size, 0); c.lineTo(-0.7 * size, 0.65 * size); c.lineTo(-0.35 * size, 0); c.lineTo(-0.7 * size, -0.65 * size); c.closePath();
    if (fill) { c.fillStyle = fill; c.fill(); }
    c.strokeStyle = stroke; c.lineWidth = 1.6; c.stroke();
    c.restore();
  };
  const dots = (c, v, list, k, color, size) => {
    c.fillStyle = color; c.strokeStyle = color; c.lineWidth = 1; c.globalAlpha = 0.55;
    c.beginPath();
    for (let i = list.starts[k]; i < list.starts[k + 1]; i++) {
      const x = v.x(left + list.xy[2 * i] / 65535 * (right - left)), y = v.y(low + list.xy[2 * i + 1] / 65535 * (high - low));
      const turn = list.theta[i] / 256 * 2 * Math.PI;
      c.rect(x - size / 2, y - size / 2, size, size);
      c.moveTo(x, y); c.lineTo(x + 7 * Math.cos(turn), y - 7 * Math.sin(turn));
    }
    c.fill(); c.stroke(); c.globalAlpha = 1;
  };
  const onRobot = (c, v, points, k, track, color, size) => {
    c.fillStyle = color;
    const [x, y, theta] = [track.x[k], track.y[k], track.theta[k]], cos = Math.cos(theta), sin = Math.sin(theta);
    for (let i = points.starts[k]; i < points.starts[k + 1]; i++) {
      const a = points.xy[2 * i] / 100, b = points.xy[2 * i + 1] / 100;
      c.fillRect(v.x(x + a * cos - b * sin) - size / 2, v.y(y + a * sin + b * cos) - size / 2, size, size);
    }
  };

  const drawScene = () => {
    const v = view(), k = state.frame;
    const [c] = fit(scene, v.height);
    c.clearRect(0, 0, v.width, v.height);
    if (image && image.complete && layers.map) {
      const [a, b, d, e] = run.map.bounds;
      c.imageSmoothingEnabled = v.scale * (d - a) / image.width < 2;
      c.filter = dark.matches ? "invert(.92)" : "none";
      c.drawImage(image, v.x(a), v.y(e), (d - a) * v.scale, (e - b) * v.scale);
      c.filter = "none";
    }
    c.lineJoin = "round";
    c.font = "12px system-ui, sans-serif";
    for (const [id, x, y] of run.landmarks) {
      c.strokeStyle = colors.landmark; c.lineWidth = 2; c.beginPath();
      c.moveTo(v.x(x) - 4, v.y(y) - 4); c.lineTo(v.x(x) + 4, v.y(y) + 4);
      c.moveTo(v.x(x) - 4, v.y(y) + 4); c.lineTo(v.x(x) + 4, v.y(y) - 4); c.stroke();
      if (run.landmarks.length <= 60) { c.fillStyle = colors.landmark; c.fillText(id, v.x(x) + 6, v.y(y) - 5); }
    }
    if (layers.truth && run.truth) {
      c.setLineDash([2, 3]); c.strokeStyle = colors.ink; c.lineWidth = 1.4;
      path(c, v, run.truth, 0, count - 1); c.setLineDash([]);
    }
    run.methods.forEach((method, m) => {
      c.strokeStyle = colors.methods[m]; c.lineWidth = m === state.focus ? 2 : 1.3;
      if (layers.paths) { c.setLineDash(dashes(m)); path(c, v, method.track, 0, k); c.setLineDash([]); }
    });
    const focus = run.methods[state.focus], color = colors.methods[state.focus];
    if (layers.weighed && focus.weighed) dots(c, v, focus.weighed, k, colors.muted, 2);
    if (layers.particles && focus.particles) dots(c, v, focus.particles, k, color, 2.4);
    if (layers.scan) {
      onRobot(c, v, run.scan, k, focus.track, colors.scan, 2.6);
      onRobot(c, v, run.sights, k, focus.track, colors.scan, 6);
    }
    run.methods.forEach((method, m) => {
      const track = method.track;
      if (layers.ellipses) {
        ellipse(c, v, track.x[k], track.y[k], method.covariance[3 * k], method.covariance[3 * k + 1], method.covariance[3 * k + 2]);
        c.strokeStyle = colors.methods[m]; c.lineWidth = 1.5; c.stroke();
      }
      robot(c, v, track.x[k], track.y[k], track.theta[k], m === state.focus ? 10 : 8, colors.methods[m], colors.paper);
    });
    if (layers.hypotheses && focus.hypotheses) {
      const list = focus.hypotheses;
      for (let i = list.starts[k]; i < list.starts[k + 1]; i++) {
        const [share, x, y, xx, xy, yy] = list.numbers.subarray(6 * i, 6 * i + 6);
        c.setLineDash([5, 3]); ellipse(c, v, x, y, xx, xy, yy); c.strokeStyle = color; c.lineWidth = 1.5; c.stroke(); c.setLineDash([]);
        if (list.starts[k + 1] - list.starts[k] > 1) { c.fillStyle = color; c.fillText(`${Math.round(100 * share)} %`, v.x(x) + 8, v.y(y) + 4); }
      }
    }
    if (run.truth && layers.truth) robot(c, v, run.truth.x[k], run.truth.y[k], run.truth.theta[k], 12, null, colors.ink);
    // A ruler.
    const length = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].find((l) => l * v.scale > 50) || 1000;
    c.strokeStyle = colors.ink; c.fillStyle = colors.ink; c.lineWidth = 2; c.beginPath();
    c.moveTo(12, v.height - 12); c.lineTo(12 + length * v.scale, v.height - 12); c.stroke();
    c.strokeStyle = colors.paper; c.lineWidth = 3; c.strokeText(`${length} m`, 12, v.height - 18);
    c.fillText(`${length} m`, 12, v.height - 18);
  };

  // One chart: a value of each method over time, drawn once; the cursor is drawn at every frame.
  const chart = (canvas, name, series, bands, log) => {
    const all = series.flatMap(([, values]) => Array.from(values).filter(Number.isFinite)).sort((a, b) => a - b);
    if (!all.length) { canvas.remove(); return null; }
    const top = Math.max(all[Math.floor(0.998 * (all.length - 1))] * 1.08, ...bands, 1e-6);
    const bottom = log ? Math.max(Math.min(all[0], top / 10), top / 1e4) : 0;
    const height = canvas.clientHeight, pad = { l: 46, r: 8, t: 20, b: 18 };
    const self = { canvas, base: null };
    const X = (t, w) => pad.l + t / (end || 1) * (w - pad.l - pad.r);
    const Y = (value) => {
      const share = log ? Math.log(Math.max(value, bottom) / bottom) / Math.log(top / bottom) : value / top;
      return height - pad.b - Math.min(1.02, share) * (height - pad.t - pad.b);
    };
    const number = (value) => (value >= 1000 ? `${+(value / 1000).toPrecision(2)}k` : `${+value.toPrecision(2)}`);
    const lines = (c, w) => {
      c.clearRect(0, 0, w, height);
      c.font = "12px system-ui, sans-serif"; c.fillStyle = colors.ink; c.fillText(name, 8, 14);
      c.fillStyle = colors.muted; c.strokeStyle = colors.grid; c.lineWidth = 1;
      const step = 10 ** Math.floor(Math.log10(top)), ticks = log
        ? Array.from({ length: 9 }, (_, i) => 10 ** (Math.ceil(Math.log10(bottom)) + i)).filter((t) => t <= top)
        : [1, 2, 5, 10].map((m) => m * step / 2).map((s) => [s, 2 * s, 3 * s]).find((t) => t[2] > top * 0.75 && t[0] < top) || [top];
      c.textAlign = "right";
      for (const t of ticks.filter((t) => t <= top)) {
        c.beginPath(); c.moveTo(pad.l, Y(t)); c.lineTo(w - pad.r, Y(t)); c.stroke(); c.fillText(number(t), pad.l - 5, Y(t) + 4);
      }
      c.textAlign = "left";
      c.fillText("0 s", pad.l, height - 4); c.textAlign = "right"; c.fillText(`${end.toFixed(0)} s`, w - pad.r, height - 4); c.textAlign = "left";
      c.setLineDash([4, 3]); c.strokeStyle = colors.muted;
      for (const band of bands) { c.beginPath(); c.moveTo(pad.l, Y(band)); c.lineTo(w - pad.r, Y(band)); c.stroke(); }
      c.setLineDash([]);
      // The chosen method last, over the paler others.
      for (const [m, values] of [...series].sort(([a], [b]) => (a === state.focus) - (b === state.focus))) {
        c.globalAlpha = m === state.focus || series.length <= 4 ? 1 : 0.45;
        c.strokeStyle = colors.methods[m]; c.lineWidth = m === state.focus ? 1.6 : 1.1; c.setLineDash(dashes(m)); c.beginPath();
        let pen = false;
        for (let i = 0; i < values.length; i++) {
          if (!Number.isFinite(values[i])) { pen = false; continue; }
          const [x, y] = [X(run.stamps[i], w), Y(values[i])];
          if (pen) c.lineTo(x, y); else c.moveTo(x, y);
          pen = true;
        }
        c.stroke(); c.setLineDash([]); c.globalAlpha = 1;
      }
    };
    self.draw = () => {
      const [c, w] = fit(canvas, height);
      if (!self.base || self.width !== w || self.focus !== state.focus) {
        lines(c, w);
        self.width = w; self.focus = state.focus;
        self.base = document.createElement("canvas");
        self.base.width = canvas.width; self.base.height = canvas.height;
        self.base.getContext("2d").drawImage(canvas, 0, 0);
      } else {
        c.clearRect(0, 0, w, height);
        c.save(); c.setTransform(1, 0, 0, 1, 0, 0); c.drawImage(self.base, 0, 0); c.restore();
      }
      const x = X(run.stamps[state.frame], w);
      c.strokeStyle = colors.ink; c.lineWidth = 1; c.beginPath(); c.moveTo(x, pad.t); c.lineTo(x, height - pad.b); c.stroke();
    };
    const seek = (event) => {
      const box = canvas.getBoundingClientRect();
      show((event.clientX - box.left - pad.l) / (box.width - pad.l - pad.r) * end);
    };
    canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); pause(); seek(event); });
    canvas.addEventListener("pointermove", (event) => { if (event.buttons) seek(event); });
    return self;
  };

  const of = (figure) => run.methods.map((method, m) => [m, method[figure] || []]);
  let charts = [];
  const makeCharts = () => {
    charts = [
      chart($("#errors"), "distance from the truth [m]", of("error"), [], true),
      chart($("#headings"), "heading error [deg]", of("heading").map(([m, v]) => [m, Array.from(v, Math.abs)]), [], true),
      chart($("#nees"), "NEES (3 is honest; 95 % lie below 7.8)", of("nees"), [3, 7.81], true),
      chart($("#lost"), "probability of being lost (doubtful from 0.5 on)", of("lost"), [0.5], false),
      chart($("#counts"), "particles", of("particle_count"), [], false),
    ].filter(Boolean);
  };

  const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : "–");
  const draw = () => {
    const k = state.frame, focus = run.methods[state.focus];
    drawScene();
    charts.forEach((c) => c.draw());
    slider.value = k;
    slider.setAttribute("aria-valuetext", `${run.stamps[k].toFixed(1)} seconds`);
    clock.textContent = `${run.stamps[k].toFixed(1)} of ${end.toFixed(1)} s`;
    const t = focus.track, kidnapped = run.kidnapped_at !== null && run.stamps[k] >= run.kidnapped_at ? ", after the kidnapping" : "";
    now.textContent = `${focus.name} at (${fixed(t.x[k], 2)}, ${fixed(t.y[k], 2)}) m, ${fixed(t.theta[k] * 180 / Math.PI, 1)}°`
      + (focus.error.length ? `, off by ${fixed(focus.error[k], 3)} m and ${fixed(focus.heading[k], 2)}°, NEES ${fixed(focus.nees[k], 2)}` : "")
      + (focus.lost ? `, lost ${fixed(focus.lost[k], 2)}` : "")
      + (focus.particle_count ? `, ${focus.particle_count[k]} particles` : "")
      + (focus.hypotheses ? ` in ${focus.hypotheses.counts[k]} cluster${focus.hypotheses.counts[k] === 1 ? "" : "s"}` : "") + kidnapped;
  };
  // The last moment that is not after a time.
  const frameAt = (time) => {
    let [a, b] = [0, count - 1];
    while (a < b) { const m = (a + b + 1) >> 1; if (run.stamps[m] <= time + 1e-4) a = m; else b = m - 1; }
    return a;
  };
  const show = (time) => {
    state.time = Math.min(end, Math.max(run.stamps[0], time));
    state.frame = frameAt(state.time);
    draw();
  };
  const step = (by) => { pause(); const k = Math.min(count - 1, Math.max(0, state.frame + by)); show(run.stamps[k]); };
  let last = 0;
  const tick = (stamp) => {
    if (!state.playing) return;
    const passed = Math.min(0.25, (stamp - last) / 1000);
    last = stamp;
    show(state.time + passed * Number(speed.value));
    if (state.time >= end) pause(); else requestAnimationFrame(tick);
  };
  const play = () => {
    if (state.time >= end) state.time = run.stamps[0];
    state.playing = true; playButton.textContent = "Pause";
    last = performance.now(); requestAnimationFrame(tick);
  };
  const pause = () => { state.playing = false; playButton.textContent = "Play"; };

  playButton.addEventListener("click", () => (state.playing ? pause() : play()));
  slider.max = count - 1;
  slider.addEventListener("input", () => { pause(); show(run.stamps[Number(slider.value)]); });
  run.methods.forEach((method, m) => focusSelect.add(new Option(method.name, m, false, m === state.focus)));
  const legend = $(".legend"), entry = (name, color, m = 0) => {
    const span = document.createElement("span");
    span.textContent = name; span.style.setProperty("--color", color); span.classList.toggle("dashes", m >= 6); legend.append(span);
  };
  if (run.truth) entry("truth", "var(--ink)"); else $("input[name=truth]").parentElement.remove();
  if (!run.map) $("input[name=map]").parentElement.remove();
  for (const list of ["particles", "weighed", "hypotheses"]) {
    if (!run.methods.some((method) => method[list])) $(`input[name=${list}]`).parentElement.remove();
  }
  run.methods.forEach((method, m) => entry(method.name, `var(--m${m % 12})`, m));
  focusSelect.addEventListener("change", () => { state.focus = Number(focusSelect.value); draw(); });
  $("#whole").addEventListener("click", () => { state.zoom = 1; state.pan = [0, 0]; draw(); });

  // Zoom with the wheel or two fingers, move by dragging.
  const zoom = (factor, x, y) => {
    const v = view(), next = Math.min(60, Math.max(1, state.zoom * factor)), scale = v.scale / state.zoom;
    const [dx, dy] = [(x - v.width / 2), -(y - v.height / 2)];
    const shift = 1 / (scale * state.zoom) - 1 / (scale * next);
    state.pan = next === 1 ? [0, 0] : [state.pan[0] + dx * shift, state.pan[1] + dy * shift];
    state.zoom = next; draw();
  };
  scene.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-0.0015 * event.deltaY), event.offsetX, event.offsetY);
  }, { passive: false });
  scene.addEventListener("pointermove", (event) => {
    if (!event.buttons || state.zoom === 1) return;
    const { scale } = view();
    state.pan = [state.pan[0] - event.movementX / scale, state.pan[1] + event.movementY / scale];
    draw();
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select, summary, a, pre")) return;
    if (event.target.matches("button, input[type=checkbox]") && event.key === " ") return;
    const keys = {
      " ": () => (state.playing ? pause() : play()),
      ArrowRight: () => step(event.shiftKey ? 10 : 1), ArrowLeft: () => step(event.shiftKey ? -10 : -1),
      Home: () => step(-count), End: () => step(count),
      "+": () => zoom(1.25, scene.clientWidth / 2, scene.clientHeight / 2),
      "-": () => zoom(0.8, scene.clientWidth / 2, scene.clientHeight / 2),
      m: () => { state.focus = (state.focus + 1) % run.methods.length; focusSelect.value = state.focus; draw(); },
    };
    const action = keys[event.key];
    if (action) { event.preventDefault(); action(); }
  });
  let resizing = 0;
  window.addEventListener("resize", () => {
    cancelAnimationFrame(resizing);
    resizing = requestAnimationFrame(() => { charts.forEach((c) => { c.base = null; }); draw(); });
  });
  readColors();
  makeCharts();
  // For tests, and for people who like consoles.
  window.player = { show, play, pause, state, run, pose: () => { const t = run.methods[state.focus].track, k = state.frame; return [t.x[k], t.y[k], t.theta[k]]; } };
  root.dataset.ready = "true";
  show(run.stamps[0]);
})();
