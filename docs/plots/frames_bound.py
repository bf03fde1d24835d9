#!/usr/bin/python3
"""RMS error of `relnav replay` over the Cramer-Rao bound for sequences of light spots with truth: table of docs/estimators.md.

docs/plots/frames_bound.py SEQ --mode coop-mono|coop-stereo [--tool build/host/bin/relnav] [--work out/plots]
The bound is that of the markers that went into each pose, for a centroid noise measured against the truth.
"""
import argparse
import json
import pathlib
import subprocess
from types import SimpleNamespace

import numpy as np
import yaml
from pose_reference import bounds, pose_error
from relnav_runs import Camera, Estimate, read_trajectory


class DistortedCamera(Camera):
    """OpenCV's k1 k2 p1 p2."""

    def __init__(self, path):
        file = yaml.safe_load(path.read_text())
        self.focal, self.middle = np.array(file['intrinsics'][:2]), np.array(file['intrinsics'][2:])
        self.T_BK = np.array(file['T_BS']['data']).reshape(4, 4)
        self.coefficients = file['distortion_coefficients']

    def project(self, p_C):
        k1, k2, p1, p2 = self.coefficients
        p_K = p_C @ self.R_KC.T + self.t_KC
        x, y = (p_K[..., :2] / p_K[..., 2:]).T
        r2 = x * x + y * y
        radial = 1 + k1 * r2 + k2 * r2 * r2
        bent = np.stack([x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                         y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y], axis=-1)
        return self.focal * bent + self.middle


def centroids(options, out):
    """[frame time, slot, uv_px] of the markers used, as FEATURES packets of cam0 say."""
    config = options.work / 'features.yaml'
    config.write_text('loop:\n  features_every_frames: 1\n')
    subprocess.run([options.tool, 'replay', '--mode', options.mode, '--dataset', options.sequence, '--config', config,
                    '--out', out, '--force'], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    text = subprocess.run([options.tool, 'tlm', 'decode', '--json', out / 'telemetry.bin'], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    for line in text.splitlines():
        packet = json.loads(line)
        if packet.get('packet') != 'FEATURES':
            continue
        for feature in packet['entries']:
            if feature['use'] == 'low_innovation':
                yield packet['time_ns'], feature['slot'], np.array([feature['u_px_256'], feature['v_px_256']]) / 256


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('sequence', type=pathlib.Path)
    parser.add_argument('--mode', required=True, choices=['coop-mono', 'coop-stereo'])
    parser.add_argument('--tool', default='build/host/bin/relnav')
    parser.add_argument('--work', default='out/plots', type=pathlib.Path)
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    out = options.work / options.sequence.name

    cameras = [DistortedCamera(options.sequence / f'mav0/cam{k}/sensor.yaml')
               for k in range(2 if options.mode == 'coop-stereo' else 1)]
    for camera in reversed(cameras):
        camera.stand_in(cameras[0])
    features = yaml.safe_load((options.sequence / 'target.yaml').read_text())['features']
    points_T = np.array([feature['xyz'] for feature in features])
    truth = read_trajectory(options.sequence / 'truth.tum')
    epoch_of = {t_ns: row for row, t_ns in enumerate(truth.t_ns)}

    # Of a stereo pair both cameras are taken to use the same markers.
    pixels = np.full((len(epoch_of), len(cameras), len(features), 2), np.nan)
    errors = []
    for t_ns, slot, uv_px in centroids(options, out):
        epoch = epoch_of[t_ns]
        p_C = truth.R_CT[epoch] @ points_T[slot] + truth.t_CT[epoch]
        errors.append(uv_px - cameras[0].project(p_C))
        pixels[epoch, :, slot] = uv_px
    errors = np.array(errors)
    rms = np.sqrt(np.mean(errors**2))
    robust = 1.4826 * np.median(np.abs(errors - np.median(errors, axis=0)))
    print(f'{len(errors)} centroids: mean {errors.mean(axis=0)}, rms {rms:.4f}, robust {robust:.4f} px')

    estimate = Estimate(out, truth)
    error = pose_error(truth, estimate)[estimate.solved]
    for name, sigma in (('rms', rms), ('robust', robust)):
        scene = SimpleNamespace(truth=truth, cameras=cameras, points_T=points_T, pixels=pixels,
                                sigma_px=np.full(len(epoch_of), sigma))
        variances = np.diagonal(bounds(scene), axis1=1, axis2=2)[estimate.solved]
        ratio = np.sqrt(np.mean(error**2, axis=0) / np.mean(variances, axis=0))
        print(f'RMS / bound at {name}: ' + ' '.join(f'{r:.2f}' for r in ratio))


if __name__ == '__main__':
    main()
