"""Chen, Chen, Wang 2015: noise and pose swept; closed forms, absolute orientation, maximum likelihood and the bound."""
import matplotlib.pyplot as plt
import matplotlib.ticker as ticker
import numpy as np
import pose_reference as reference
import relnav_runs

STYLES = {'motor': ('#c0392b', 's', 'motor'), 'orthogonal': ('#e08e0b', '^', 'orthogonal'),
          'absolute': ('#2e8b57', 'x', 'absolute orientation'), 'ml': ('#2c5f8a', 'o', 'maximum likelihood')}
QUANTITIES = [('attitude across the line of sight (x, y), deg', [3, 4], np.degrees(1)),
              ('attitude about the line of sight (z), deg', [5], np.degrees(1)),
              ('position across (x, y), mm', [0, 1], 1e3), ('position along (z), mm', [2], 1e3)]


def solve_all(scenario):
    runs = {method: scenario.solve('--method', method) for method in ('motor', 'orthogonal', 'ml')}
    runs['absolute'] = reference.AbsoluteOrientation(scenario)
    return {method: runs[method] for method in STYLES}


def rms(values, axes, groups):
    """Root mean square an axis, over epochs and axes of each group."""
    return np.array([np.sqrt(np.nanmean(values[group][:, axes])) for group in groups])


def draw(axes, x, groups, squares, variances, quantity, log):
    name, which, scale = quantity
    axes.plot(x, scale * rms(variances, which, groups), color='black', linewidth=2.5, alpha=0.35, label='Cramér-Rao bound')
    for method, (colour, marker, label) in STYLES.items():
        hollow = {'markerfacecolor': 'none'} if method != 'absolute' else {}
        axes.plot(x, scale * rms(squares[method], which, groups), color=colour, marker=marker, markersize=4.5,
                  linewidth=0.9, label=label, **hollow)
    axes.set_title(name, fontsize=9, loc='left')
    if log:
        axes.set_yscale('log')
        axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter(ticker.FormatStrFormatter('%g'))
        axes.yaxis.set_minor_formatter(ticker.NullFormatter())
    else:
        axes.set_ylim(bottom=0)


def finish(figure, axes, path):
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, ncol=5, loc='upper center')
    figure.tight_layout(rect=(0, 0, 1, 0.96))
    figure.savefig(path)
    plt.close(figure)


def plot_noise(path, scenario, squares, variances):
    levels = np.unique(scenario.sigma_px)
    groups = [scenario.sigma_px == level for level in levels]
    levels = np.where(levels < 0.02, 0, levels)  # stated as 0.01 px, made with none
    figure, grid = plt.subplots(2, 2, figsize=(10, 6.5), sharex=True)
    variances = np.where(scenario.sigma_px[:, None] < 0.02, 0, variances)
    for axes, quantity in zip(grid.flat, QUANTITIES):
        draw(axes, levels, groups, squares, variances, quantity, log=False)
    for axes in grid[-1]:
        axes.set_xlabel('noise of a pixel coordinate, 1 sigma, px')
    finish(figure, grid[0, 0], path)


def plot_pose(path, scenario, squares, variances, sweeps):
    labels = ['pitch (about x), deg', 'yaw (about y), deg', 'roll (about z), deg', 'range, m']
    figure, grid = plt.subplots(4, 4, figsize=(13, 11), sharex='col', sharey='row')
    for column, (label, (x, groups)) in enumerate(zip(labels, sweeps)):
        for row, quantity in enumerate(QUANTITIES):
            draw(grid[row, column], x, groups, squares, variances, quantity, log=True)
            if column > 0:
                grid[row, column].set_title('', loc='left')
        grid[-1, column].set_xlabel(label)
    finish(figure, grid[0, 0], path)


def pose_sweeps(truth):
    """Epochs by pose: three sweeps of an angle at one range, then one of the range."""
    phi = np.degrees(reference.rotation_vector(truth.R_CT))
    keys = [tuple(row) for row in np.round(np.column_stack([phi, truth.t_CT]), 6)]
    starts = [0] + [i for i in range(1, len(keys)) if keys[i] != keys[i - 1]] + [len(keys)]
    groups = [np.arange(a, b) for a, b in zip(starts, starts[1:])]
    # The range sweep begins where the range leaves that of the angles.
    first_range = next(i for i, group in enumerate(groups) if abs(truth.t_CT[group[0], 2] - truth.t_CT[0, 2]) > 1e-6)
    each = first_range // 3
    sweeps = [(phi[[g[0] for g in groups[axis * each:(axis + 1) * each]], axis], groups[axis * each:(axis + 1) * each])
              for axis in range(3)]
    return sweeps + [(truth.t_CT[[g[0] for g in groups[first_range:]], 2], groups[first_range:])]


def print_table(name, scenario, runs, errors, squares, bound, chosen):
    variances = np.diagonal(bound, axis1=1, axis2=2)
    scale = np.array([1e3] * 3 + [np.degrees(1)] * 3)
    print(f'{name}: RMS x y z mm, x y z deg, over the bound; mean NEES of the stated covariance')
    print('  bound     ', *np.round(scale * np.sqrt(np.mean(variances[chosen], axis=0)), 3))
    for method, run in runs.items():
        each = np.sqrt(np.nanmean(squares[method][chosen], axis=0))
        text = [*np.round(scale * each, 3), '|', *np.round(each / np.sqrt(np.mean(variances[chosen], axis=0)), 2)]
        if hasattr(run, 'covariance'):
            e, P = errors[method][chosen], run.covariance[chosen]
            text += ['| NEES', np.round(np.nanmean(np.einsum('ei,eij,ej->e', e, np.linalg.inv(P), e)), 2),
                     '| no pose', np.sum(~run.solved[chosen])]
        print(f'  {method:10}', *text)


def make(tool, work, images):
    for name, count in (('stereo-noise', '1000'), ('stereo-pose', '200')):
        scenario = relnav_runs.Scenario(tool, name, work / name, ['--count', count])
        runs = solve_all(scenario)
        bound = reference.bounds(scenario)
        variances = np.diagonal(bound, axis1=1, axis2=2)
        errors = {method: reference.pose_error(scenario.truth, run) for method, run in runs.items()}
        squares = {method: error**2 for method, error in errors.items()}
        if name == 'stereo-noise':
            plot_noise(images / 'stereo-noise.png', scenario, squares, variances)
            print_table(f'{name}, 1 px', scenario, runs, errors, squares, bound, scenario.sigma_px == 1)
            print_table(f'{name}, all with noise', scenario, runs, errors, squares, bound, scenario.sigma_px > 0.02)
        else:
            sweeps = pose_sweeps(scenario.truth)
            plot_pose(images / 'stereo-pose.png', scenario, squares, variances, sweeps)
            everything = np.ones(len(bound), dtype=bool)
            print_table(name, scenario, runs, errors, squares, bound, everything)
            far = np.zeros(len(bound), dtype=bool)
            far[np.concatenate(sweeps[3][1][-5:])] = True
            print_table(f'{name}, 8 to 10 m', scenario, runs, errors, squares, bound, far)
