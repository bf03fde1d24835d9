"""Runs the relnav tool and reads what it writes."""
import pathlib
import subprocess

import numpy as np
import yaml


class Scenario:
    """Cameras, target, observations and truth of one `relnav scenario`."""

    def __init__(self, tool, name, folder, options=()):
        self.tool, self.name, self.folder = tool, name, pathlib.Path(folder)
        command = [tool, 'scenario', name, '--out', str(self.folder), '--force', *options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        self.cameras = [Camera(path) for path in sorted(self.folder.glob('cam?.yaml'))]
        for camera in self.cameras[1:]:
            camera.stand_in(self.cameras[0])
        self.cameras[0].stand_in(self.cameras[0])
        features = yaml.safe_load((self.folder / 'target.yaml').read_text())['features']
        self.points_T = np.array([feature['xyz'] for feature in features])
        row_of = {feature['id']: row for row, feature in enumerate(features)}
        self.truth = read_trajectory(self.folder / 'truth.tum')
        # An epoch a row; NaN where a camera does not see a feature.
        epochs = {t_ns: row for row, t_ns in enumerate(self.truth.t_ns)}
        self.pixels = np.full((len(epochs), len(self.cameras), len(features), 2), np.nan)
        self.sigma_px = np.full(len(epochs), np.nan)
        for line in (self.folder / 'observations.csv').read_text().splitlines()[1:]:
            t_ns, cam, feature, u, v, sigma = line.split(',')
            epoch = epochs[int(t_ns)]
            self.pixels[epoch, int(cam), row_of[int(feature)]] = float(u), float(v)
            self.sigma_px[epoch] = float(sigma)

    def solve(self, *options):
        """One `relnav solve`: an estimate an epoch, NaN where it has none."""
        out = self.folder / ('solve' + ''.join(options))
        command = [self.tool, 'solve', '--mode', 'coop-stereo' if len(self.cameras) == 2 else 'coop-mono']
        for index in range(len(self.cameras)):
            command += ['--camera', str(self.folder / f'cam{index}.yaml')]
        command += ['--target', str(self.folder / 'target.yaml'), '--observations',
                    str(self.folder / 'observations.csv'), '--out', str(out), '--force', *options]
        run = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if run.returncode not in (0, 1):  # 1: no pose at the end
            raise SystemExit(f'{" ".join(command)}\n{run.stderr}')
        return Estimate(out, self.truth)


class Camera:
    """Pinhole camera of a file without distortion: p_K = R_KC p_C + t_KC, pixel = focal p / z + middle."""

    def __init__(self, path):
        file = yaml.safe_load(path.read_text())
        if file['distortion_model'] != 'none':
            raise SystemExit(f'{path}: distortion_model is {file["distortion_model"]} (expected none)')
        self.focal, self.middle = np.array(file['intrinsics'][:2]), np.array(file['intrinsics'][2:])
        self.T_BK = np.array(file['T_BS']['data']).reshape(4, 4)

    def stand_in(self, first):
        T_KC = np.linalg.inv(self.T_BK) @ first.T_BK
        self.R_KC, self.t_KC = T_KC[:3, :3], T_KC[:3, 3]

    def project(self, p_C):
        p_K = p_C @ self.R_KC.T + self.t_KC
        return self.focal * p_K[..., :2] / p_K[..., 2:] + self.middle


class Trajectory:
    def __init__(self, t_ns, t_CT, R_CT):
        self.t_ns, self.t_CT, self.R_CT = t_ns, t_CT, R_CT


class Estimate:
    """Poses and covariances of a run at the epochs of the truth."""

    def __init__(self, folder, truth):
        poses = read_trajectory(folder / 'trajectory.tum')
        row_of = {t_ns: row for row, t_ns in enumerate(truth.t_ns)}
        rows = [row_of[t_ns] for t_ns in poses.t_ns]
        count = len(truth.t_ns)
        self.R_CT, self.t_CT = np.full((count, 3, 3), np.nan), np.full((count, 3), np.nan)
        self.covariance = np.full((count, 6, 6), np.nan)
        self.R_CT[rows], self.t_CT[rows] = poses.R_CT, poses.t_CT
        numbers = np.atleast_2d(np.genfromtxt(folder / 'covariance.csv', delimiter=',', skip_header=1))[:, 1:]
        a, b = np.triu_indices(6)
        for row, values in zip(rows, numbers):
            self.covariance[row, a, b] = self.covariance[row, b, a] = values
        self.solved = np.isfinite(self.t_CT[:, 0])


def read_trajectory(path):
    """TUM file; times as whole nanoseconds."""
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith('#')]
    t_ns = [int(line[0].replace('.', '')) for line in lines]  # 9 decimals
    numbers = np.array([[float(value) for value in line[1:]] for line in lines]).reshape(-1, 7)
    x, y, z, w = numbers[:, 3:].T / np.linalg.norm(numbers[:, 3:], axis=1)
    R_CT = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]).transpose(2, 0, 1)
    return Trajectory(t_ns, numbers[:, :3], R_CT)
