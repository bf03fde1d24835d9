"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { summary, estimate, truth } = data;
  const main = document.getElementById("report");
  const t = estimate.t;
  const axisColours = ["#d1495b", "#2a9d5c", "#3066be"];
  const axisNames = ["x", "y", "z"];

  function element(tag, attributes = {}, ...children) {
    const e = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value);
    for (const child of children) e.append(child);
    return e;
  }
  function svg(tag, attributes = {}) {
    const e = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value);
    return e;
  }
  const round = (v, digits = 3) => (v === null || v === undefined ? "–" : Number(v.toPrecision(digits)).toString());
  const degrees = (rad) => (rad * 180) / Math.PI;

  // Head and figures
  const good = summary.exit_status === 0;
  main.append(element("h1", {}, "Relative navigation run", element("span", { class: good ? "badge" : "badge bad" }, good ? "done" : "fault")));
  const what = [summary.dataset, summary.mode, summary.motion, summary.range_m > 0 ? `start range ${round(summary.range_m)} m` : ""];
  main.append(element("p", { class: "sub" }, what.filter(Boolean).join(" · ") + (summary.problem ? ` — ${summary.problem}` : "")));
  const tiles = element("div", { class: "tiles" });
  const tile = (key, value) => tiles.append(element("div", { class: "tile" }, element("div", { class: "v" }, value), element("div", { class: "k" }, key)));
  tile("frames", `${summary.frames_seen} / ${summary.frames_listed}`);
  tile("poses", `${summary.poses}`);
  tile("resets", `${summary.resets}`);
  tile("inliers of features, mean", `${round(summary.mean_inliers)} / ${round(summary.mean_features)}`);
  tile("step time, median", `${round(summary.step_us.median / 1000)} ms`);
  tile("step time, slowest", `${round(summary.step_us.max / 1000)} ms`);
  if (summary.evaluation) {
    const e = summary.evaluation;
    tile("attitude error, largest", `${round(degrees(e.attitude_rad.max))}°`);
    tile("attitude error, last", `${round(degrees(e.attitude_rad.last))}°`);
    tile("of the angle turned", e.attitude_last_percent_of_angle_turned === undefined ? "–" : `${round(e.attitude_last_percent_of_angle_turned)} %`);
    tile("rate error, mean", `${round(degrees(e.rate_rad_s.mean))} °/s`);
    tile("position error, RMS", `${round(e.position_m.rms)} m`);
    if (e.nees && e.nees.epochs > 0) tile(`attitude NEES, mean (band ${round(e.nees.mean_band_95[0])} to ${round(e.nees.mean_band_95[1])})`, round(e.nees.mean));
  }
  main.append(tiles);
  if (data.figures.length > 0) {
    main.append(element("h2", {}, "Figures held against"));
    const table = element("table", { class: "figures" });
    const row = (cells, tag = "td") => { const r = element("tr"); cells.forEach((c) => r.append(c instanceof Node ? c : element(tag, {}, c))); table.append(r); };
    row(["figure", "reached", "paper", "must", "goal"], "th");
    for (const [name, reached, paper, must, goal] of data.figures) {
      const kept = must === null || (reached !== null && reached <= must);
      row([name, element("td", { class: kept ? "good" : "bad" }, round(reached)), round(paper), round(must), round(goal)]);
    }
    main.append(table);
  }

  // Plots
  const plots = [];
  const sync = uPlot.sync("frames");
  const line = (label, stroke, more = {}) => ({ label, stroke, width: 1.6, points: { show: false }, value: (u, v) => round(v, 4), ...more });
  function plot(parent, title, note, series, columns, options = {}) {
    const card = element("div", { class: "card" }, element("h3", {}, title), element("p", {}, note));
    parent.append(card);
    const axis = { stroke: "#5c6b7a", grid: { stroke: "#edf1f4", width: 1 }, ticks: { stroke: "#dfe5eb", width: 1 }, font: "12px system-ui, sans-serif" };
    const chart = new uPlot({
      width: card.clientWidth - 30, height: 230,
      cursor: { sync: { key: sync.key } },
      scales: { x: { time: false }, y: options.range ? { range: options.range } : {} },
      legend: { live: true },
      axes: [{ ...axis, values: (u, v) => v.map((x) => `${x} s`) }, { ...axis, size: 58 }],
      series: [{ label: "t", value: (u, v) => (v === null ? "–" : `${v.toFixed(2)} s`) }, ...series],
      bands: options.bands || [],
    }, [t, ...columns], card);
    plots.push([chart, card]);
  }
  function section(title) {
    main.append(element("h2", {}, title));
    const grid = element("div", { class: "plots" });
    main.append(grid);
    return grid;
  }
  const plus = (a, b) => a.map((v, i) => (v === null || b[i] === null ? null : v + b[i]));
  const minus = (a, b) => a.map((v, i) => (v === null || b[i] === null ? null : v - b[i]));
  const negative = (a) => a.map((v) => (v === null ? null : -v));
  const alpha = (colour, share) => colour + Math.round(share * 255).toString(16).padStart(2, "0");

  // Three axes, estimate solid, truth dashed, 3 sigma as a band.
  function against(parent, title, note, values, bounds, reference) {
    const series = [], columns = [], bands = [];
    for (let a = 0; a < 3; a++) {
      const c = axisColours[a];
      columns.push(plus(values[a], bounds[a]), minus(values[a], bounds[a]));
      series.push(line("", alpha(c, 0), { width: 0, class: "bound" }), line("", alpha(c, 0), { width: 0, class: "bound" }));
      bands.push({ series: [columns.length - 1, columns.length], fill: alpha(c, 0.13) });
    }
    for (let a = 0; a < 3; a++) { columns.push(values[a]); series.push(line(axisNames[a], axisColours[a])); }
    if (reference) for (let a = 0; a < 3; a++) { columns.push(reference[a]); series.push(line(`${axisNames[a]} truth`, "#1d2733", { dash: [5, 5], width: 1.1 })); }
    plot(parent, title, note, series, columns, { bands });
  }
  // Error of one quantity with its own 3 sigma about zero, an axis a plot would waste room: three axes in one.
  function error(parent, title, note, values, bounds) {
    const series = [], columns = [];
    for (let a = 0; a < 3; a++) { columns.push(values[a]); series.push(line(axisNames[a], axisColours[a])); }
    for (let a = 0; a < 3; a++) {
      columns.push(bounds[a], negative(bounds[a]));
      const thin = { dash: [3, 4], width: 1 };
      series.push(line(`3σ ${axisNames[a]}`, alpha(axisColours[a], 0.75), thin), line("", alpha(axisColours[a], 0.75), { ...thin, class: "bound" }));
    }
    plot(parent, title, note, series, columns);
  }

  if (summary.poses > 0) {
    const s = section("Motion of the target relative to the camera");
    const withTruth = truth ? " Dashed: truth." : "";
    against(s, "Attitude since the first pose, deg", `Rotation vector, axes of the camera. Band: 3σ.${withTruth}`, estimate.attitude, estimate.attitude_3sigma, truth && truth.attitude);
    if (truth) error(s, "Attitude error, deg", "Truth minus estimate, referred to the first pose. Dashed: the filter's 3σ.", truth.attitude_error, estimate.attitude_3sigma);
    else plot(s, "Attitude 3σ, deg", "What the filter believes of its error; there is no truth to compare with.", axisNames.map((n, a) => line(n, axisColours[a])), estimate.attitude_3sigma);
    against(s, "Rate, deg/s", `Axes of the camera. Band: 3σ.${truth ? " Dashed: truth over a window (see summary.json)." : ""}`, estimate.rate, estimate.rate_3sigma, truth && truth.rate);
    const known = data.fitted === false;
    const scaled = truth && !known ? ` Scaled by the fitted ${round(data.scale, 4)}.` : "";
    against(s, "Position, m", `Target in the camera.${scaled} Band: 3σ.${withTruth}`, estimate.position, estimate.position_3sigma, truth && truth.position);
    if (truth) error(s, "Position error, m", known ? "Truth minus estimate. Dashed: 3σ." : "Truth minus estimate, one scale and one body point fitted. Dashed: 3σ.", truth.position_error, estimate.position_3sigma);
    if (truth && truth.nees && truth.nees.some((v) => v !== null)) {
      const band = truth.nees_band || [null, null], level = (v) => t.map(() => v), thin = { dash: [4, 4], width: 1 };
      plot(s, "NEES", "Normalised estimation error squared, one epoch at a time. Dashed: 95 % band of an honest covariance.",
        [line("NEES", "#7b4fa3"), line("band", "#1d2733", thin), line("", "#1d2733", { ...thin, class: "bound" })], [truth.nees, level(band[0]), level(band[1])]);
    }
    plot(s, "Test ratio", "Normalised innovation squared over its 99 % bound; above 1 the measurements contradict the filter.",
      [line("test ratio", "#7b4fa3")], [estimate.test_ratio]);
  }
  {
    const s = section("Frame by frame");
    plot(s, "Features", "In the state, found in the frame, and used.",
      [line("in the state", "#8a97a5"), line("found", "#e09f3e"), line("used", "#2a9d5c")], [estimate.features, estimate.matched, estimate.inliers],
      { range: (u, low, high) => [0, Math.max(high, 1) * 1.08] });
    const stages = [["predict", "#3066be"], ["match", "#e09f3e"], ["update", "#d1495b"], ["detect", "#2a9d5c"], ["telemetry", "#7b4fa3"]];
    const step = estimate.stage_ms.total.map((v, i) => (v === null ? null : v - estimate.stage_ms.acquire[i]));
    plot(s, "Time per stage, ms", "Reading the image from disk is not counted.",
      [line("step", "#1d2733"), ...stages.map(([name, colour]) => line(name, colour))], [step, ...stages.map(([name]) => estimate.stage_ms[name])],
      { range: (u, low, high) => [0, Math.max(high, 0.1) * 1.05] });
    const modes = ["STANDBY", "ACQUIRE", "TRACK", "LOST"];
    const seen = [...new Set(estimate.mode.filter((m) => m !== null))];
    if (seen.length > 1) plot(s, "Mode", modes.map((m, i) => `${i} ${m}`).join(" · "), [line("mode", "#1d2733", { value: (u, v) => modes[v] ?? "–" })], [estimate.mode], { range: [-0.2, 3.2] });
  }
  if (data.events.length > 0) {
    main.append(element("h2", {}, "Events"));
    const kinds = [...new Set(data.events.map(([, text]) => text.split(/\s+/)[4]))];
    const end = Math.max(...t.filter((v) => v !== null), 1e-9), width = 1000, left = 190, high = 20;
    const chart = svg("svg", { viewBox: `0 0 ${width} ${high * (kinds.length + 1)}`, class: "events" });
    kinds.forEach((kind, k) => {
      const name = svg("text", { x: 0, y: high * (k + 0.7), "font-size": 12, fill: "#1d2733" });
      name.append(kind);
      chart.append(name, svg("line", { x1: left, x2: width, y1: high * (k + 0.5), y2: high * (k + 0.5), stroke: "#dfe5eb" }));
    });
    for (const [time, text] of data.events) {
      const kind = text.split(/\s+/)[4];
      const dot = svg("circle", { cx: left + ((width - left - 8) * Math.max(0, time)) / end, cy: high * (kinds.indexOf(kind) + 0.5), r: 4, fill: "#3066be" });
      const title = svg("title");
      title.append(`${time.toFixed(2)} s  ${text}`);
      dot.append(title);
      chart.append(dot);
    }
    const foot = svg("text", { x: left, y: high * (kinds.length + 0.7), "font-size": 12, fill: "#5c6b7a" });
    foot.append(`0 to ${round(end)} s`);
    chart.append(foot);
    main.append(element("div", { class: "card" }, chart));
  }

  // The target's way in the camera's frame; the mouse turns it.
  if (summary.poses > 1) {
    main.append(element("h2", {}, "Relative trajectory"));
    const canvas = element("canvas", { width: 900, height: 420 });
    main.append(element("div", { class: "card" }, element("p", {}, "Origin of the target frame in the camera frame (x right, y down, z ahead). Solid: estimate; dashed: truth. Drag to turn."), canvas));
    const ways = [[estimate.position, "#3066be", []]];
    if (truth) ways.push([truth.position, "#1d2733", [6, 5]]);
    const points = ways.flatMap(([p]) => p[0].map((x, i) => [x, p[1][i], p[2][i]])).filter((p) => p.every((v) => v !== null));
    points.push([0, 0, 0]);
    const low = [0, 1, 2].map((a) => Math.min(...points.map((p) => p[a]))), top = [0, 1, 2].map((a) => Math.max(...points.map((p) => p[a])));
    const middle = low.map((v, a) => (v + top[a]) / 2), size = Math.max(...low.map((v, a) => top[a] - v), 1e-9);
    let yaw = -0.7, pitch = 0.4;
    const draw = () => {
      const g = canvas.getContext("2d"), zoom = 380 / size / 1.2;
      g.clearRect(0, 0, canvas.width, canvas.height);
      const at = (p) => {
        const [x, y, z] = p.map((v, a) => v - middle[a]);
        const u = x * Math.cos(yaw) + z * Math.sin(yaw), w = -x * Math.sin(yaw) + z * Math.cos(yaw);
        return [450 + zoom * u, 210 + zoom * (y * Math.cos(pitch) - w * Math.sin(pitch))];
      };
      const stroke = (list, colour, dash, thick) => {
        g.beginPath(); g.strokeStyle = colour; g.setLineDash(dash); g.lineWidth = thick;
        list.forEach((p, i) => (i === 0 ? g.moveTo(...at(p)) : g.lineTo(...at(p))));
        g.stroke();
      };
      const arrow = size / 6;
      axisColours.forEach((c, a) => {
        const tip = [0, 0, 0];
        tip[a] = arrow;
        stroke([[0, 0, 0], tip], c, [], 2);
        g.fillStyle = c; g.font = "12px system-ui"; g.fillText(axisNames[a], ...at(tip));
      });
      g.fillStyle = "#1d2733"; g.fillText("camera", at([0, 0, 0])[0] + 6, at([0, 0, 0])[1] + 14);
      for (const [p, colour, dash] of ways) stroke(p[0].map((x, i) => [x, p[1][i], p[2][i]]).filter((q) => q.every((v) => v !== null)), colour, dash, 1.8);
    };
    canvas.addEventListener("pointermove", (e) => { if (e.buttons) { yaw += e.movementX / 150; pitch += e.movementY / 150; draw(); } });
    draw();
  }
  addEventListener("resize", () => plots.forEach(([chart, card]) => chart.setSize({ width: card.clientWidth - 30, height: 230 })));

  // Frames with features
  const uses = [["not expected", "#8a97a5"], ["not found", "#e09f3e"], ["outlier", "#ff4d4d"], ["inlier", "#3ddc84"], ["rescued inlier", "#35d0e0"], ["new", "#f2e94e"]];
  function mark(group, use, u, v, size) {
    const stroke = uses[use][1], common = { stroke, "stroke-width": 1.6, fill: "none", "vector-effect": "non-scaling-stroke" };
    if (use === 1 || use === 2) group.append(svg("path", { d: `M${u - size} ${v - size}L${u + size} ${v + size}M${u + size} ${v - size}L${u - size} ${v + size}`, ...common }));
    else if (use === 5) group.append(svg("rect", { x: u - size, y: v - size, width: 2 * size, height: 2 * size, ...common }));
    else group.append(svg("circle", { cx: u, cy: v, r: size, ...common }));
  }
  if (data.snapshots.length > 0) {
    main.append(element("h2", {}, "Frames with the tracked features"));
    const legend = element("div", { class: "legend" });
    uses.forEach(([name], use) => {
      if (use === 0) return;
      const icon = svg("svg", { viewBox: "0 0 18 18" });
      mark(icon, use, 9, 9, 4.5);
      legend.append(element("span", {}, icon, name));
    });
    legend.append(element("span", {}, "A line joins prediction and measurement, five times longer than it is."));
    main.append(legend);
    const frames = element("div", { class: "frames" });
    for (const s of data.snapshots) {
      const picture = svg("svg", { viewBox: `-0.5 -0.5 ${s.width} ${s.height}` });
      picture.append(svg("image", { href: `data:image/png;base64,${s.png}`, x: -0.5, y: -0.5, width: s.width, height: s.height }));
      const size = s.width / 110;
      let used = 0;
      for (const [use, pu, pv, mu, mv] of s.features) {
        if (use === 0 || pu === null) continue;
        const measured = use >= 2;
        const u = measured ? mu : pu, v = measured ? mv : pv;
        if (measured && use !== 5) picture.append(svg("line", { x1: u, y1: v, x2: u + 5 * (pu - mu), y2: v + 5 * (pv - mv), stroke: uses[use][1], "stroke-width": 1.2, "vector-effect": "non-scaling-stroke" }));
        mark(picture, use, u, v, size);
        if (use === 3 || use === 4) used++;
      }
      frames.append(element("div", { class: "frame" }, picture, element("div", {}, element("b", {}, `frame ${s.frame}`), ` · ${s.t.toFixed(2)} s · ${s.mode} · ${used} used of ${s.features.length}`)));
    }
    main.append(frames);
  }
})();
