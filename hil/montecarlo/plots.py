#!/usr/bin/env python3
"""Distributions of a campaign as PNG images beside its report: DIR/plots/<figure>.png, and outcomes.png.

    python3 hil/montecarlo/plots.py DIR        Packages: python3-matplotlib
"""
import json
import pathlib
import re
import sys


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


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    folder = pathlib.Path(sys.argv[1])
    try:
        summary = json.loads((folder / "summary.json").read_text())
    except (OSError, ValueError) as error:
        print(f"plots.py: {folder / 'summary.json'}: {error} (expected what relnav montecarlo writes)", file=sys.stderr)
        return 2
    try:
        import matplotlib
    except ImportError:
        print("plots.py: no plots without matplotlib (apt-get install python3-matplotlib); report.html has them", file=sys.stderr)
        return 1
    matplotlib.use("Agg")
    from matplotlib import pyplot

    plots = folder / "plots"
    plots.mkdir(exist_ok=True)

    def draw(name, label, how, what):
        figure, axes = pyplot.subplots(figsize=(7, 4), dpi=110)
        how(axes, what)
        axes.set_xlabel(label)
        figure.tight_layout()
        # Without the date and version of who drew it: the same summary gives the same bytes.
        figure.savefig(plots / (re.sub(r"[^A-Za-z0-9_.-]", "_", name) + ".png"), metadata={"Software": None})
        pyplot.close(figure)

    draw("outcomes", "", outcomes, summary["outcomes"])
    for name, d in summary["figures"].items():
        draw(name, name, histogram, d)
    if summary["nees"]:
        draw("nees", "NEES per degree of freedom, mean of a run", histogram, summary["nees"]["run_means"])
    print(f"{len(list(plots.glob('*.png')))} plots in {plots}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
