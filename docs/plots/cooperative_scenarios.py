#!/usr/bin/python3
"""Plots and tables of docs/cooperative-scenarios.md: runs `relnav scenario` and `relnav solve` and compares with the truth.

docs/plots/cooperative_scenarios.py [--tool build/host/bin/relnav] [--work out/plots] [--images docs/img]
Debian packages: tests/packages/docs.txt. The same version of matplotlib gives the same bytes.
"""
import argparse
import pathlib

import matplotlib

matplotlib.use('Agg')
import stereo_plots
import table1_plots


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--tool', default='build/host/bin/relnav')
    parser.add_argument('--work', default='out/plots', type=pathlib.Path, help='folder for scenarios and runs')
    parser.add_argument('--images', default='docs/img', type=pathlib.Path, help='folder for the pictures')
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    options.images.mkdir(parents=True, exist_ok=True)
    matplotlib.rcParams.update({'figure.dpi': 100, 'font.size': 9, 'axes.grid': True, 'grid.alpha': 0.3,
                                'axes.spines.top': False, 'axes.spines.right': False, 'legend.frameon': False,
                                'lines.linewidth': 1.2, 'savefig.bbox': 'tight'})
    table1_plots.make(options.tool, options.work, options.images)
    stereo_plots.make(options.tool, options.work, options.images)


if __name__ == '__main__':
    main()
