#!/usr/bin/env python3
"""The plots of a report.html as PNG images beside it: DIR/plots/<what>.png.

    python3 hil/report/plots.py DIR [DIR...]       Packages: python3-matplotlib

DIR: a run, as relnav sim or relnav replay wrote it, or a campaign of relnav montecarlo.
"""
import base64
import io
import json
import math
import pathlib
import re
import sys

AXES = "xyz"
COLOURS = ("#c0392b", "#27864b", "#3066be")
MODES = ("STANDBY", "ACQUIRE", "TRACK", "LOST", "SAFE")


def numbers(values):
    return [math.nan if v is None else v for v in values]


def read_run(folder):
    """What the report shows, of the page itself: figures and page cannot differ."""
    page = (folder / "report.html").read_text()
    begin = '<script id="data" type="application/json">'
    if begin not in page:
        raise ValueError(f"{folder / 'report.html'}: holds no data (expected the report of a run)")
    return json.loads(page.split(begin, 1)[1].split("</script>", 1)[0])


def three(axes, t, values, sigmas=None, truth=None):
    for i, name in enumerate(AXES):
        axes.plot(t, numbers(values[i]), color=COLOURS[i], linewidth=1, label=name)
        if truth:
            axes.plot(t, numbers(truth[i]), color=COLOURS[i], linewidth=1, linestyle=":", label=f"{name}, truth")
        if sigmas:
            s = numbers(sigmas[i])
            axes.fill_between(t, [-v for v in s], s, color=COLOURS[i], alpha=0.12, linewidth=0)
    axes.legend(fontsize=7, ncol=2, loc="upper right")


def mark_events(axes, events):
    for t, _ in events:
        axes.axvline(t, color="#888888", linewidth=0.5)


def time_line(pyplot, title, label, draw):
    figure, axes = pyplot.subplots(figsize=(8, 4), dpi=110)
    draw(axes)
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("time, s")
    axes.set_ylabel(label)
    axes.grid(alpha=0.3)
    return figure


def nees(axes, t, truth):
    axes.plot(t, numbers(truth["nees"]), color=COLOURS[2], linewidth=1)
    if "nees_band" in truth:
        axes.axhspan(*truth["nees_band"], color=COLOURS[1], alpha=0.15, label="95 % of an honest filter's epochs")
        axes.legend(fontsize=7)
    values = [v for v in truth["nees"] if v]
    if values:
        axes.set_yscale("log")
        axes.set_title(f"NEES, mean {sum(values) / len(values):.3g}", fontsize=10)


def modes(figure, estimate, events):
    above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [3, 1]})
    for name, colour in (("features", "#999999"), ("matched", COLOURS[2]), ("inliers", COLOURS[1])):
        above.plot(estimate["t"], numbers(estimate[name]), color=colour, linewidth=1, label=name)
    above.legend(fontsize=7)
    above.set_title(f"features, modes and {len(events)} events", fontsize=10)
    below.step(estimate["t"], numbers(estimate["mode"]), where="post", color="#1d2733", linewidth=1)
    below.set_yticks(range(len(MODES)), MODES, fontsize=7)
    below.set_ylim(-0.5, len(MODES) - 0.5)
    below.set_xlabel("time, s")
    for axes in (above, below):
        mark_events(axes, events)
        axes.grid(alpha=0.3)


def trajectory(figure, estimate, truth):
    axes = figure.add_subplot(projection="3d")
    for what, style, label in ((estimate, "-", "estimate"), (truth, ":", "truth")):
        if what:
            axes.plot(*(numbers(what["position"][i]) for i in (0, 2, 1)), style, linewidth=1.2, label=label)
    axes.set_xlabel("x right, m", fontsize=8)
    axes.set_ylabel("z along the boresight, m", fontsize=8)
    axes.set_zlabel("y down, m", fontsize=8)
    axes.invert_zaxis()
    axes.set_title("the target in the camera's frame", fontsize=10)
    axes.legend(fontsize=7)


def strip(figure, snapshots, pyplot):
    columns = min(4, len(snapshots))
    rows = -(-len(snapshots) // columns)
    for k, shot in enumerate(snapshots):
        axes = figure.add_subplot(rows, columns, k + 1)
        axes.imshow(pyplot.imread(io.BytesIO(base64.b64decode(shot["png"])), format="png"), cmap="gray", vmin=0, vmax=1)
        seen = [f for f in shot["features"] if f[3] is not None and f[4] is not None]
        axes.plot([f[3] for f in seen], [f[4] for f in seen], "+", color="#21c45d", markersize=4)
        axes.set_title(f"{shot['t']:.1f} s, {shot['mode']}", fontsize=8)
        axes.axis("off")


def figures_of_run(data, pyplot):
    estimate, truth, events = data["estimate"], data["truth"], data["events"]
    t = estimate["t"]
    figures = {
        "attitude": time_line(pyplot, "attitude since the first frame (rotation vector)", "deg",
                              lambda a: three(a, t, estimate["attitude"], truth=truth and truth["attitude"])),
        "rate": time_line(pyplot, "rate of the target in C", "deg/s",
                          lambda a: three(a, t, estimate["rate"], truth=truth and truth["rate"])),
        "stages": time_line(pyplot, "time of each stage", "ms", lambda a: (
            [a.plot(t, numbers(v), linewidth=1, label=n) for n, v in estimate["stage_ms"].items()], a.legend(fontsize=7))),
    }
    if truth:
        figures["attitude_error"] = time_line(pyplot, "attitude error, with 3 sigma as stated", "deg", lambda a: three(
            a, t, truth["attitude_error"], sigmas=estimate["attitude_3sigma"]))
        figures["position_error"] = time_line(pyplot, "position error, with 3 sigma as stated", "m", lambda a: three(
            a, t, truth["position_error"], sigmas=estimate["position_3sigma"]))
        figures["nees"] = time_line(pyplot, "NEES", "", lambda a: nees(a, t, truth))
    for name, draw in (("timeline", lambda f: modes(f, estimate, events)),
                       ("trajectory", lambda f: trajectory(f, estimate, truth)),
                       ("frames", lambda f: strip(f, data["snapshots"], pyplot))):
        if name == "frames" and not data["snapshots"]:
            continue
        figures[name] = pyplot.figure(figsize=(10, 7.5) if name == "frames" else (8, 5), dpi=110)
        draw(figures[name])
    return figures


def histogram(axes, d):
    h = d["histogram"]
    n = len(h["counts"])
    width = (h["high"] - h["low"]) / n or 1.0
    axes.bar([h["low"] + k * width for k in range(n)], h["counts"], width, align="edge", color="#3066be", alpha=0.7)
    for percentile, style in (("50", "-"), ("5", "--"), ("95", "--")):
        axes.axvline(d["percentiles"][percentile], color="#1d2733", linestyle=style, linewidth=1)
    outside = f", {h['below'] + h['above']} beyond the plot" if h["below"] + h["above"] else ""
    axes.set_title(f"{d['count']} runs, mean {d['mean']:.4g}, sd {d['sd']:.4g}, max {d['max']:.4g}{outside}", fontsize=9)
    axes.set_ylabel("runs")


def outcomes(axes, shares):
    names = [name for name, o in shares.items()]
    values = [o["share"] for o in shares.values()]
    low = [o["share"] - o["share_95"][0] for o in shares.values()]
    high = [o["share_95"][1] - o["share"] for o in shares.values()]
    axes.bar(names, values, color="#3066be", alpha=0.7, yerr=[[max(v, 0) for v in low], [max(v, 0) for v in high]], capsize=4)
    axes.set_ylabel("share of runs, 95 % (Wilson)")


def figures_of_campaign(summary, pyplot):
    drawn = [("outcomes", "", outcomes, summary["outcomes"])]
    drawn += [(name, name, histogram, d) for name, d in summary["figures"].items()]
    if summary["nees"]:
        drawn.append(("nees", "NEES per degree of freedom, mean of a run", histogram, summary["nees"]["run_means"]))
    figures = {}
    for name, label, draw, what in drawn:
        figures[name], axes = pyplot.subplots(figsize=(7, 4), dpi=110)
        draw(axes, what)
        axes.set_xlabel(label)
    return figures


def figures_of(folder, pyplot):
    try:
        summary = json.loads((folder / "summary.json").read_text())
        return figures_of_campaign(summary, pyplot) if "outcomes" in summary else figures_of_run(read_run(folder), pyplot)
    except OSError as error:
        raise ValueError(f"{error.filename}: {error.strerror} (expected the folder of a run or of a campaign)") from None
    except (KeyError, json.JSONDecodeError) as error:
        raise ValueError(f"{folder}: {error!r} (expected the folder of a run or of a campaign)") from None


def save(folder, figures, pyplot):
    plots = folder / "plots"
    plots.mkdir(exist_ok=True)
    for name, figure in figures.items():
        figure.tight_layout()
        # Without the date and version of who drew it: the same report gives the same bytes.
        figure.savefig(plots / (re.sub(r"[^A-Za-z0-9_.-]", "_", name) + ".png"), metadata={"Software": None})
        pyplot.close(figure)
    print(f"{len(figures)} plots in {plots}")


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__.strip(), file=sys.stderr)
        return 2
    try:
        import matplotlib
    except ImportError:
        print("plots.py: no plots without matplotlib (apt-get install python3-matplotlib); report.html has them", file=sys.stderr)
        return 1
    matplotlib.use("Agg")
    from matplotlib import pyplot

    for folder in map(pathlib.Path, sys.argv[1:]):
        try:
            figures = figures_of(folder, pyplot)
        except ValueError as error:
            print(f"plots.py: {error}", file=sys.stderr)
            return 2
        save(folder, figures, pyplot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
