"""What the plots compare with, independent of relnav: rotations, Cramer-Rao bound, absolute orientation."""
import numpy as np


def rotation_exp(phi):
    """Active rotation by |phi| about phi."""
    angle = np.linalg.norm(phi)
    x, y, z = phi / angle if angle > 0 else phi
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rotation_vector(R):
    """Inverse of rotation_exp() for an array of matrices, away from half a turn."""
    axis = 0.5 * np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], -1)
    sine = np.linalg.norm(axis, axis=-1)
    angle = np.arctan2(sine, 0.5 * (np.trace(R, axis1=-2, axis2=-1) - 1))
    return axis * np.where(sine > 0, angle / np.where(sine > 0, sine, 1), 1)[..., None]


def rotation_angle(R):
    """rad, precise up to half a turn."""
    skew = R - np.swapaxes(R, -1, -2)
    sine = np.sqrt(0.125 * np.sum(skew**2, axis=(-1, -2)))
    return np.arctan2(sine, 0.5 * (np.trace(R, axis1=-2, axis2=-1) - 1))


def pose_error(truth, estimate):
    """[dt dphi] an epoch, truth minus estimate, axes of C."""
    turn = truth.R_CT @ np.swapaxes(estimate.R_CT, -1, -2)
    return np.concatenate([truth.t_CT - estimate.t_CT, rotation_vector(turn)], axis=-1)


def bounds(scenario):
    """Cramer-Rao bound at the truth, 6 x 6 an epoch: inverse of J'J / sigma^2 over all pixels seen, J by central differences."""
    step = 1e-6
    result = []
    for R_CT, t_CT, pixels, sigma_px in zip(scenario.truth.R_CT, scenario.truth.t_CT, scenario.pixels, scenario.sigma_px):
        seen = np.isfinite(pixels)

        def image(d):
            p_C = scenario.points_T @ (rotation_exp(d[3:]) @ R_CT).T + t_CT + d[:3]
            return np.stack([camera.project(p_C) for camera in scenario.cameras])[seen]

        J = np.stack([(image(step * e) - image(-step * e)) / (2 * step) for e in np.eye(6)], axis=1)
        result.append(np.linalg.inv(J.T @ J) * sigma_px**2)
    return np.array(result)


def triangulate(scenario):
    """Points in C0 from both cameras, epoch by epoch: linear least squares on the two projections."""
    epochs, _, features, _ = scenario.pixels.shape
    points = np.empty((epochs, features, 3))
    for epoch in range(epochs):
        for feature in range(features):
            A, b = [], []
            for camera, uv in zip(scenario.cameras, scenario.pixels[epoch, :, feature]):
                for axis, image in enumerate((uv - camera.middle) / camera.focal):
                    row = -np.eye(3)[axis] + np.array([0, 0, image])
                    A.append(row @ camera.R_KC)
                    b.append(-row @ camera.t_KC)
            points[epoch, feature] = np.linalg.lstsq(np.array(A), np.array(b), rcond=None)[0]
    return points


class AbsoluteOrientation:
    """Umeyama 1991, without scale, over triangulated points."""

    def __init__(self, scenario):
        points_C = triangulate(scenario)
        middle_C, middle_T = points_C.mean(axis=1), scenario.points_T.mean(axis=0)
        S = np.einsum('efi,fj->eij', points_C - middle_C[:, None], scenario.points_T - middle_T)
        U, _, Vt = np.linalg.svd(S)
        signs = np.ones((len(S), 3))
        signs[:, 2] = np.sign(np.linalg.det(U @ Vt))
        self.R_CT = (U * signs[:, None]) @ Vt
        self.t_CT = middle_C - self.R_CT @ middle_T


def sequential_rotations(R_CT):
    """Rodrigues parameters along a trajectory by the paper's rule: set index and largest |g_j| an epoch; and |g| in the first set.

    R_CT = C(g) R^(i), C(g) the transpose of the active rotation of g; switch when the largest |g_j| exceeds 1.
    """
    flips = [np.diag(d) for d in ([1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1])]

    def gibbs(C):
        q = np.array([C[1, 2] - C[2, 1], C[2, 0] - C[0, 2], C[0, 1] - C[1, 0]])
        return q / (1 + np.trace(C))

    sets, largest, single = [], [], []
    now = 0
    for R in R_CT:
        g = gibbs(R @ flips[now].T)
        if np.max(np.abs(g)) > 1:
            j = int(np.argmax(np.abs(g))) + 1
            now = j if now == 0 else 0 if now == j else 6 - j - now
            g = gibbs(R @ flips[now].T)
        sets.append(now)
        largest.append(np.max(np.abs(g)))
        single.append(np.tan(rotation_angle(R) / 2))
    return np.array(sets), np.array(largest), np.array(single)
