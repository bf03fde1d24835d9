"use strict";
(() => {
  const { summary, failures } = JSON.parse(document.getElementById("data").textContent);
  const main = document.getElementById("report");
  function element(tag, attributes = {}, ...children) {
    const e = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value);
    for (const child of children) e.append(child);
    return e;
  }
  const round = (v, digits = 3) => (v === null || v === undefined ? "–" : Number(v.toPrecision(digits)).toString());
  const percent = (v) => `${round(100 * v)} %`;
  const band = ([low, high]) => `${round(low, 4)} to ${round(high, 4)}`;

  const complete = summary.missing === 0;
  main.append(element("h1", {}, `Campaign ${summary.scenario}`, element("span", { class: complete ? "badge" : "badge bad" }, complete ? "complete" : `${summary.missing} runs missing`)));
  main.append(element("p", { class: "sub" }, [summary.scenario_file, `CRC ${summary.scenario_crc}`, `relnav ${summary.version}`].join(" · ")));
  const tiles = element("div", { class: "tiles" });
  const tile = (key, value) => tiles.append(element("div", { class: "tile" }, element("div", { class: "v" }, value), element("div", { class: "k" }, key)));
  tile("runs", `${summary.results}`);
  tile("failed runs", `${summary.failures}`);
  tile("poses of frames", `${summary.poses} / ${summary.frames}`);
  tile("wrong poses marked valid", `${summary.invalid_flagged_valid.poses}`);
  if (summary.nees) {
    tile(`NEES per degree of freedom (band ${band(summary.nees.band_95)})`, round(summary.nees.mean, 4));
    tile("mean over runs, 95 %", band(summary.nees.mean_of_runs_95));
    tile("runs inside their 95 % band", percent(summary.nees.runs_in_their_band_95));
  }
  main.append(tiles);

  function table(head, rows) {
    const t = element("table", {}, element("tr", {}, ...head.map((h) => element("th", {}, h))));
    for (const row of rows) t.append(element("tr", {}, ...row.map((c) => element("td", {}, `${c}`))));
    main.append(element("div", { class: "card scroll" }, t));
  }
  main.append(element("h2", {}, "Outcomes"));
  table(["outcome", "runs", "share", "95 % (Wilson)"], Object.entries(summary.outcomes).map(([name, o]) => [name, o.count, percent(o.share), `${percent(o.share_95[0])} to ${percent(o.share_95[1])}`]));

  // Distributions
  const plots = [];
  function histogram(parent, title, d) {
    const p = d.percentiles, h = d.histogram, n = h.counts.length, step = (h.high - h.low) / n;
    const outside = h.below + h.above > 0 ? ` Beyond the plot: ${h.below} below, ${h.above} above.` : "";
    const card = element("div", { class: "card" }, element("h3", {}, title),
      element("p", {}, `${d.count} runs, mean ${round(d.mean)}, sd ${round(d.sd)}, min ${round(d.min)}, max ${round(d.max)}. Percentiles 1: ${round(p[1])}, 5: ${round(p[5])}, 25: ${round(p[25])}, 50: ${round(p[50])}, 75: ${round(p[75])}, 95: ${round(p[95])}, 99: ${round(p[99])}.${outside}`));
    parent.append(card);
    if (n < 2) return;
    const axis = { stroke: "#5c6b7a", grid: { stroke: "#edf1f4", width: 1 }, ticks: { stroke: "#dfe5eb", width: 1 }, font: "12px system-ui, sans-serif" };
    const x = h.counts.map((_, i) => h.low + (i + 0.5) * step);
    const chart = new uPlot({
      width: card.clientWidth - 30, height: 200,
      scales: { x: { time: false, range: [h.low, h.high] }, y: { range: (u, low, high) => [0, Math.max(high, 1) * 1.08] } },
      axes: [axis, { ...axis, size: 58 }],
      series: [{ label: "at", value: (u, v) => round(v, 4) }, { label: "runs", stroke: "#3066be", fill: "#3066be55", width: 1.2, points: { show: false }, paths: uPlot.paths.bars({ size: [1, 100], align: 0 }) }],
    }, [x, h.counts], card);
    plots.push([chart, card]);
  }
  function section(title) {
    main.append(element("h2", {}, title));
    const grid = element("div", { class: "plots" });
    main.append(grid);
    return grid;
  }
  if (Object.keys(summary.figures).length > 0) {
    const s = section("Figures over the runs");
    for (const [name, d] of Object.entries(summary.figures)) histogram(s, name, d);
  }
  if (summary.nees) histogram(section("Consistency"), "NEES per degree of freedom, mean of a run", summary.nees.run_means);
  addEventListener("resize", () => plots.forEach(([chart, card]) => chart.setSize({ width: card.clientWidth - 30, height: 200 })));

  if (Object.keys(summary.dispersions).length > 0) {
    main.append(element("h2", {}, "What was dispersed"));
    table(["quantity", "mean", "sd", "min", "max", "mean of failed runs"], Object.entries(summary.dispersions).map(([name, d]) => [name, round(d.mean), round(d.sd), round(d.min), round(d.max), d.failed.count > 0 ? round(d.failed.mean) : "–"]));
  }
  if (summary.failures > 0) {
    main.append(element("h2", {}, "Failures by cause"));
    table(["outcome", "problem", "runs", "first run"], summary.causes.map((c) => [c.outcome, c.problem, c.runs, c.first_run]));
    main.append(element("h2", {}, failures.length < summary.failures ? `The first ${failures.length} failed runs (all: failures.csv)` : "Failed runs"));
    table(["run", "seed", "outcome", "problem", "again with"], failures);
  }
})();
