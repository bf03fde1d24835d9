#!/usr/bin/env python3
"""The plots of a run's report.html as PNG images beside it: DIR/plots/<what>.png.

    python3 hil/report/plots.py DIR [DIR...]       DIR: what relnav sim or relnav replay wrote. Packages: python3-matplotlib
"""
import base64
import io
import json
import math
import pathlib
import sys

AXES = "xyz"
COLOURS = ("#c0392b", "#27864b", "#3066be")
MODES = ("STANDBY", "ACQUIRE", "TRACK", "LOST", "SAFE")


def numbers(values):
    return [math.nan if v is None else v for v in values]


def read_data(folder):
    """What the report shows, of the page itself: figures and page cannot differ."""
    page = (folder / "report.html").read_text()
    begin = '<script id="data" type="application/json">'
    if begin not in page:
        raise ValueError(f"{folder / 'report.html'}: holds no data (expected the report of a run of relnav sim or relnav replay)")
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


def nees(axes, t, truth, degrees):
    axes.plot(t, numbers(truth["nees"]), color=COLOURS[2], linewidth=1)
    if "nees_band" in truth:
        axes.axhspan(*truth["nees_band"], color=COLOURS[1], alpha=0.15, label="95 % of an honest filter's epochs")
        axes.legend(fontsize=7)
    values = [v for v in truth["nees"] if v]
    if values:
        axes.set_yscale("log")
        axes.set_title(f"NEES, mean {sum(values) / len(values):.3g}{degrees}", fontsize=10)


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


def plot(folder, data, pyplot):
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
        figures["nees"] = time_line(pyplot, "NEES", "", lambda a: nees(a, t, truth, ""))
    for name, draw in (("timeline", lambda f: modes(f, estimate, events)),
                       ("trajectory", lambda f: trajectory(f, estimate, truth)),
                       ("frames", lambda f: strip(f, data["snapshots"], pyplot))):
        if name == "frames" and not data["snapshots"]:
            continue
        figures[name] = pyplot.figure(figsize=(10, 7.5) if name == "frames" else (8, 5), dpi=110)
        draw(figures[name])
    plots = folder / "plots"
    plots.mkdir(exist_ok=True)
    for name, figure in figures.items():
        figure.tight_layout()
        # Without the date and version of who drew it: the same run gives the same bytes.
        figure.savefig(plots / f"{name}.png", metadata={"Software": None})
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
            data = read_data(folder)
        except OSError as error:
            print(f"plots.py: {error.filename}: {error.strerror} (expected the report of a run)", file=sys.stderr)
            return 2
        except ValueError as error:
            print(f"plots.py: {error}", file=sys.stderr)
            return 2
        plot(folder, data, pyplot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
