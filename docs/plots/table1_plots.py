"""Yue, Hou 2010, Table 1: errors over time with their bound, the crossing of half a turn, the run without switching."""
import matplotlib.pyplot as plt
import numpy as np
import pose_reference as reference
import relnav_runs

CROSSING_S = 2228.6  # the paper's
ERROR, BOUND, MARK = '#2c5f8a', '#c0392b', '#555555'


def mark_crossing(axes):
    axes.axvline(CROSSING_S, color=MARK, linewidth=0.9, linestyle=':')


def plot_errors(path, t_s, error, bound):
    """As the paper's figures: x along the boresight (z of C), y and z across (x and y of C)."""
    sigma = np.sqrt(np.diagonal(bound, axis1=1, axis2=2))
    scale = np.array([1, 1, 1] + 3 * [np.degrees(1)])
    names = ['position across, x of C, m', 'position across, y of C, m', 'position along, z of C, m',
             'attitude about x of C, deg', 'attitude about y of C, deg', 'attitude about z of C, deg']
    figure, grid = plt.subplots(3, 2, figsize=(10, 7), sharex=True)
    for k, axes in enumerate(grid.T.flat):
        line, = axes.plot(t_s, scale[k] * error[:, k], color=ERROR, linewidth=0.6)
        limit, = axes.plot(t_s, 3 * scale[k] * sigma[:, k], color=BOUND)
        axes.plot(t_s, -3 * scale[k] * sigma[:, k], color=BOUND)
        mark_crossing(axes)
        top = 1.25 * 3 * scale[k] * np.max(sigma[:, k])
        axes.set_ylim(-top, top)
        axes.set_title(names[k], fontsize=9, loc='left')
        axes.set_xlim(0, t_s[-1])
    for axes in grid[-1]:
        axes.set_xlabel('time, s')
    figure.legend([line, limit], ['error, truth minus estimate', '3 sigma of the Cramér-Rao bound'], ncol=2,
                  loc='upper center', bbox_to_anchor=(0.5, 1.0))
    figure.tight_layout(rect=(0, 0, 1, 0.96))
    figure.savefig(path)
    plt.close(figure)


def plot_attitude(path, t_s, R_CT):
    sets, largest, single = reference.sequential_rotations(R_CT)
    figure, (angle, index, size) = plt.subplots(3, 1, figsize=(8, 7), sharex=True, height_ratios=[2, 1, 2])
    angle.plot(t_s, np.degrees(reference.rotation_angle(R_CT)), color=ERROR)
    angle.set_ylabel('relative angle, deg')
    angle.set_yticks(range(0, 181, 45))
    angle.annotate(f'180 deg at {CROSSING_S} s', (CROSSING_S, 180), (2700, 165), fontsize=9,
                   arrowprops={'arrowstyle': '-', 'color': MARK})
    index.step(t_s, sets, where='mid', color=ERROR)
    index.set_ylabel('set')
    index.set_yticks(range(4))
    index.set_ylim(-0.3, 3.3)
    size.semilogy(t_s, single, color=BOUND, label='|g| in the first set: no switching')
    size.semilogy(t_s, largest, color=ERROR, label='largest |g_j| with switching')
    size.axhline(256, color=MARK, linewidth=0.9, linestyle='--')
    size.annotate("g'g leaves Q16.47 above", (60, 300), fontsize=8, color=MARK)
    size.axhline(1, color=MARK, linewidth=0.9, linestyle='--')
    size.set_ylim(1e-2, 3e3)
    size.set_ylabel('Rodrigues parameters')
    size.legend(loc='upper right', bbox_to_anchor=(1.0, 0.79))
    size.set_xlabel('time, s')
    size.set_xlim(0, t_s[-1])
    for axes in (angle, index, size):
        mark_crossing(axes)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)
    return largest, single


def distance_sigma(a, b, bound):
    d = reference.pose_error(a, b)
    return np.sqrt(np.einsum('ei,eij,ej->e', d, np.linalg.inv(bound), d))


def plot_arithmetic(path, t_s, runs, best, bound):
    """Distance from the double solution with switching, in sigma of the bound; epochs without a pose as crosses on top."""
    top, equal = 1.0, 1e-11
    figure, columns = plt.subplots(2, 2, figsize=(10, 6), sharey=True, sharex='col', width_ratios=[2, 1])
    for row, switching in enumerate((True, False)):
        for axes, (low, high) in zip(columns[row], ((0, t_s[-1]), (CROSSING_S - 60, CROSSING_S + 60))):
            for (scalar, switched), run in sorted(runs.items(), reverse=True):
                if switched != switching or (scalar == 'double' and switching):
                    continue
                colour = {'double': '#2e8b57', 'float': BOUND, 'fixed': ERROR}[scalar]
                name = {'double': 'double', 'float': 'float', 'fixed': 'fixed point, Q16.47'}[scalar]
                far = np.maximum(distance_sigma(run, best, bound), equal)
                inside = (t_s >= low) & (t_s <= high)
                axes.semilogy(t_s[inside], far[inside], '.', markersize=2.5 if high > 5000 else 5, color=colour,
                              label=name)
                lost = inside & ~run.solved
                if np.any(lost):
                    axes.semilogy(t_s[lost], np.full(np.sum(lost), top), 'x', color=colour, label=f'no pose: {name}')
            mark_crossing(axes)
            if axes is columns[row, 0]:
                axes.annotate('the same digits in the file', (60, 2 * equal), fontsize=8, color=MARK)
            axes.set_ylim(equal / 3, 5)
            axes.set_xlim(low, high)
        columns[row, 0].set_ylabel('distance from double, sigma')
        columns[row, 0].set_title('with switching' if switching else 'without switching', fontsize=9, loc='left')
        columns[row, 1].set_title('around the crossing', fontsize=9, loc='left')
    for axes in columns[1]:
        axes.set_xlabel('time, s')
    handles, names = columns[1, 1].get_legend_handles_labels()
    figure.legend(handles, names, ncol=4, loc='upper center', markerscale=2)
    figure.tight_layout(rect=(0, 0, 1, 0.95))
    figure.savefig(path)
    plt.close(figure)


def make(tool, work, images):
    scenario = relnav_runs.Scenario(tool, 'table1', work / 'table1')
    t_s = np.array(scenario.truth.t_ns) * 1e-9
    bound = reference.bounds(scenario)
    runs = {(scalar, switching): scenario.solve('--scalar', scalar, *([] if switching else ['--no-switching']))
            for scalar in ('double', 'float', 'fixed') for switching in (True, False)}
    best = runs['double', True]
    error = reference.pose_error(scenario.truth, best)
    plot_errors(images / 'table1-errors.png', t_s, error, bound)
    largest, single = plot_attitude(images / 'table1-attitude.png', t_s, best.R_CT)
    plot_arithmetic(images / 'table1-arithmetic.png', t_s, runs, best, bound)

    rms = np.sqrt(np.mean(error**2, axis=0))
    sigma = np.sqrt(np.mean(np.diagonal(bound, axis1=1, axis2=2), axis=0))
    scale = np.array([1, 1, 1] + 3 * [np.degrees(1)])
    print('table1: x y z m, x y z deg')
    print('  RMS     ', *np.round(rms * scale, 5))
    print('  bound   ', *np.round(sigma * scale, 5))
    print('  RMS/CRLB', *np.round(rms / sigma, 3))
    nees = np.einsum('ei,eij,ej->e', error, np.linalg.inv(bound), error)
    print(f'  error in the bound, mean square {np.mean(nees):.2f}; outside of 3 sigma '
          f'{100 * np.mean(np.abs(error) > 3 * np.sqrt(np.diagonal(bound, axis1=1, axis2=2))):.2f} %')
    print(f'  largest |g_j| with switching {np.max(largest):.3f}, |g| without {np.max(single):.0f}')
    for (scalar, switching), run in runs.items():
        far = distance_sigma(run, best, bound)
        print(f'  {scalar}{"" if switching else ", no switching"}: {np.sum(~run.solved)} lost at', t_s[~run.solved],
              f'distance from double {np.nanmax(far):.1e} sigma')
