"""Each contradiction's figures against a computation that shares no code with them."""

import json

import numpy as np
import pytest
from scipy import linalg, optimize

from twin.paper import contradictions

M = np.array([[1.3005, -0.0846], [-0.0846, 0.5663]])
K = np.array([[1047.3, -824.1], [-824.1, 841.6]])
R52 = np.array([[72.8876, -45.6374], [-45.6374, 46.3942]])
R53 = np.array([[0.3955, -0.0485], [-0.0485, 0.1838]])
OMEGA = 2 * np.pi * np.array([1.912, 6.847])
XI = np.array([0.0118, 0.0039])


def figure(identifier, name):
    (found,) = [c for c in contradictions() if c.id == identifier]
    return found.figure(name)


def test_n1_alpha_and_beta_by_cramers_rule():
    (a, b), (c, d) = ((1 / w, w) for w in OMEGA)
    determinant = a * d - b * c
    assert figure("N1", "alpha") == pytest.approx(2 * (XI[0] * d - b * XI[1]) / determinant)
    assert figure("N1", "beta") == pytest.approx(2 * (a * XI[1] - c * XI[0]) / determinant)
    assert figure("N1", "alpha") == pytest.approx(0.2791, abs=5e-5)
    assert figure("N1", "xi_1 of (49)") == pytest.approx(
        (0.1752 / OMEGA[0] + 3.4355e-5 * OMEGA[0]) / 2
    )


def test_n1_no_rounding_of_the_modes_reaches_49():
    largest = 0.0
    for signs in np.ndindex(2, 2, 2, 2):
        shift = np.array(signs) * 2 - 1
        w = 2 * np.pi * (np.array([1.912, 6.847]) + 5e-4 * shift[:2])
        C = 0.5 * np.column_stack([1 / w, w])
        largest = max(largest, abs(0.1752 / np.linalg.solve(C, XI + 5e-5 * shift[2:])[0]))
    assert largest < 0.64
    assert figure("N1", "misfit") > 100


def test_n2_the_pair_behind_53_by_two_of_its_entries():
    alpha, beta = np.linalg.solve([[M[0, 0], K[0, 0]], [M[1, 1], K[1, 1]]], [R53[0, 0], R53[1, 1]])
    assert figure("N2", "alpha of (53)") == pytest.approx(alpha, rel=1e-3)
    assert figure("N2", "beta of (53)") == pytest.approx(beta, rel=1e-2)
    assert figure("N2", "residual") < 5e-5
    assert figure("N2", "misfit from (47)-(48)") <= 1
    assert figure("N2", "misfit") > 100
    by_49 = 0.1752 * M + 3.4355e-5 * K
    assert figure("N2", "R_11 by (49)") == pytest.approx(by_49[0, 0])
    assert figure("N2", "R_22 by (49)") == pytest.approx(by_49[1, 1])


def test_n3_the_frequencies_by_the_characteristic_polynomial():
    a = np.linalg.det(M)
    b = -(M[0, 0] * K[1, 1] + M[1, 1] * K[0, 0] - 2 * M[0, 1] * K[0, 1])
    squares = np.sort(np.roots([a, b, np.linalg.det(K)]))
    for mode, square in enumerate(squares, start=1):
        name = f"f_{mode} of (50)-(51)"
        assert figure("N3", name) == pytest.approx(np.sqrt(square) / (2 * np.pi), rel=1e-9)
        ratio = -(K[0, 0] - square * M[0, 0]) / (K[0, 1] - square * M[0, 1])
        assert figure("N3", f"shape {mode} of (50)-(51)") == pytest.approx(ratio, rel=1e-9)
    assert figure("N3", "f_1 of (50)-(51)") == pytest.approx(1.882, abs=5e-4)
    assert figure("N3", "f_2 of (50)-(51)") == pytest.approx(7.087, abs=5e-4)
    assert figure("N3", "misfit") > 100


def test_n3_the_printed_shapes_are_not_orthogonal():
    first, second = np.array([1, 0.937]), np.array([1, -2.180])
    for name, metric in (("M", M), ("K", K)):
        product = first @ metric @ second
        size = np.sqrt((first @ metric @ first) * (second @ metric @ second))
        assert figure("N3", f"cross product through {name}") == pytest.approx(product / size)


def test_n4_the_poles_by_the_determinant():
    zero = lambda s: np.linalg.det(M * s**2 + R52 * s + K)  # noqa: E731
    for name in ("first real pole", "second real pole"):
        near = figure("N4", name)
        assert optimize.brentq(zero, near - 2, near + 2) == pytest.approx(near, rel=1e-9)
    product = np.linalg.det(K) / np.linalg.det(M)
    squared = product / (figure("N4", "first real pole") * figure("N4", "second real pole"))
    trace = np.trace(np.linalg.solve(M, R52))
    real = (-trace - figure("N4", "first real pole") - figure("N4", "second real pole")) / 2
    assert figure("N4", "xi_1 of (50)-(52)") == pytest.approx(-real / np.sqrt(squared), rel=1e-6)


def scaled_misfits(theta):
    """Fit two complex scales to (50)-(52) by (41), from many starts; worst relative miss."""
    poles = OMEGA * (-XI + 1j * np.sqrt(1 - XI**2))
    shapes = np.array([[1, 1], np.array([0.937, 2.180]) * np.exp(1j * np.array(theta))])
    target = [M, K, R52]

    def matrices(x):
        W = shapes * np.sqrt(x[:2] + 1j * x[2:])
        blocks = [2 * np.real(W * poles**p @ W.T) for p in (1, -1, 2)]
        m = np.linalg.inv(blocks[0])
        return [m, -np.linalg.inv(blocks[1]), -m @ blocks[2] @ m]

    def miss(x):
        return np.concatenate(
            [(a - b).ravel() / np.abs(b).max() for a, b in zip(matrices(x), target, strict=True)]
        )

    rng = np.random.default_rng(0)
    starts = rng.uniform(-0.05, 0.05, (10, 4)) * np.array([1, 0.2, 1, 0.2])
    fits = [optimize.least_squares(miss, start, x_scale=0.01, max_nfev=300) for start in starts]
    return min(np.abs(fit.fun).max() for fit in fits)


def test_n5_and_n6_only_one_sign_of_the_phases_gives_the_printed_matrices():
    assert scaled_misfits([-0.1076, -3.1642]) < 1e-3
    assert scaled_misfits([0.1076, -3.1642]) > 1e-2
    assert scaled_misfits([0.1076, 3.1642]) > 1e-2
    assert scaled_misfits([-0.1076, 3.1642]) > 1e-2
    assert figure("N5", "misfit") <= 1
    assert figure("N5", "relative miss, digits as printed") < 1e-3
    assert figure("N5", "|W W^T| / |W|^2") > 0.1
    assert figure("N6", "misfit, Theta_1 turned") == figure("N5", "misfit")
    assert figure("N6", "misfit as printed") > 1000
    assert figure("N6", "misfit, Theta_2 turned") > 1000
    assert figure("N6", "misfit, both turned") > 1000


@pytest.mark.parametrize("name", ["(50)-(51)", "lumped"])
def test_n7_the_largest_phase_by_first_order_perturbation(name):
    k = 24 * 2.0e11 * 2.917e-12 / 0.3**3
    m, s = (M, K) if name == "(50)-(51)" else (np.diag([0.65, 1.55]), [[2 * k, -k], [-k, k]])
    squares, u = linalg.eigh(s, m)
    w = np.sqrt(squares)
    r = 2 * np.sqrt(XI[0] * w[0] * XI[1] * w[1])
    mixed = w[0] * r / (squares[1] - squares[0])
    phase = mixed * abs(u[1, 1] / u[1, 0] - u[0, 1] / u[0, 0])
    assert figure("N7", f"largest phase, {name}") == pytest.approx(phase, rel=5e-3)
    assert figure("N7", f"largest phase, {name}") < 0.1076 / 10


def test_n7_no_structure_has_the_printed_complex_modes():
    total = figure("N7", "sign choices with indefinite M") + figure(
        "N7", "sign choices with negative R"
    )
    assert total == 4


def test_n9_the_second_storey_would_need_a_negative_spring():
    for mode, ratio in ((0, 0.937), (1, -2.180)):
        k = OMEGA[mode] ** 2 * ratio / (ratio - 1)
        assert figure("N9", f"k_2/m_2 by mode {mode + 1}") == pytest.approx(k)
    assert figure("N9", "k_2/m_2 by mode 1") < 0 < figure("N9", "k_2/m_2 by mode 2")


def test_n9_the_upper_floor_of_any_shear_building_moves_more_in_its_first_mode():
    rng = np.random.default_rng(1)
    for k1, k2, m1, m2 in 10 ** rng.uniform(-1, 1, (200, 4)):
        _, shapes = linalg.eigh([[k1 + k2, -k2], [-k2, k2]], np.diag([m1, m2]))
        assert shapes[1, 0] / shapes[0, 0] > 1


def test_n10_mass_ratio_and_mac():
    assert figure("N10", "m_1/m_2 of (47)-(48)") == pytest.approx(0.937 * 2.180)
    assert figure("N10", "m_1/m_2 of (5)") == pytest.approx(0.65 / 1.55)
    assert figure("N10", "m_1/m_2 of (50)") == pytest.approx(1.3005 / 0.5663)
    for mode, (a, b) in enumerate((((1, 0.937), (1, 1.812)), ((1, -2.18), (1, -0.2314))), start=1):
        cosine = np.dot(a, b) / np.linalg.norm(a) / np.linalg.norm(b)
        assert figure("N10", f"MAC {mode}") == pytest.approx(cosine**2, abs=1e-3)
        cosine = np.dot(a[::-1], b) / np.linalg.norm(a) / np.linalg.norm(b)
        assert figure("N10", f"MAC {mode}, floors swapped") == pytest.approx(cosine**2, abs=1e-3)


def test_n11_moving_mass_and_the_beams_share():
    assert figure("N11", "moving mass of (50)") == pytest.approx(1.3005 + 0.5663 - 2 * 0.0846)
    assert figure("N11", "moving mass of (5)") == pytest.approx(2.2)
    s = np.linspace(0, 1, 100_001)
    share = np.trapezoid((1 - 3 * s**2 + 2 * s**3) * (3 * s**2 - 2 * s**3), s)
    assert figure("N11", "beam share of M_12") == pytest.approx(share, rel=1e-6)


def test_n12_springs_and_compliance():
    assert figure("N12", "storey 1") == pytest.approx(1047.3 - 824.1)
    assert figure("N12", "storey 2") == pytest.approx(824.1)
    assert figure("N12", "floor 2 to ground") == pytest.approx(17.5)
    assert figure("N12", "compliance of (51)") == pytest.approx(841.6 / (1047.3 * 841.6 - 824.1**2))
    assert figure("N12", "compliance of (6)-(7)") == pytest.approx(
        1 / figure("N12", "lumped storey")
    )


def test_n13_no_slender_body_of_that_length_has_that_inertia():
    m, half = 0.083, 0.0825
    assert figure("N13", "largest about the centre") == pytest.approx(m * half**2)
    assert figure("N13", "rod about the centre") == pytest.approx(m * (2 * half) ** 2 / 12)
    assert figure("N13", "rod about the hinge") == pytest.approx(m * (2 * half) ** 2 / 3)
    assert figure("N13", "largest about the centre") < 8.32e-4
    rng = np.random.default_rng(2)
    for _ in range(200):
        s, weight = rng.uniform(0, 2 * half, 20), rng.uniform(0, 1, 20)
        # Bring the centre of mass to the middle with a point mass at the lighter end.
        moment = np.sum(weight * (s - half))
        weight, s = (
            np.append(weight, abs(moment) / half),
            np.append(s, half - half * np.sign(moment)),
        )
        inertia = np.sum(weight * (s - half) ** 2) / weight.sum() * m
        assert inertia <= figure("N13", "largest about the centre") + 1e-12


def test_n13_and_n14_frequencies_with_the_pendulum():
    def frequencies(inertia):
        m, half = 0.083, 0.0825
        mass, stiffness = np.zeros((3, 3)), np.zeros((3, 3))
        mass[:2, :2], stiffness[:2, :2] = M, K
        mass[1:, 1:] += [[m, m * half], [m * half, m * half**2 + inertia]]
        stiffness[2, 2] = m * 9.81 * half
        return np.sqrt(linalg.eigvalsh(stiffness, mass)) / (2 * np.pi)

    found = frequencies(8.32e-4)
    assert figure("N13", "pendulum frequency as printed") == pytest.approx(found[0], rel=1e-4)
    about_hinge = frequencies(8.32e-4 - 0.083 * 0.0825**2)[0]
    assert figure("N13", "pendulum frequency, about the hinge") == pytest.approx(
        about_hinge, rel=1e-4
    )
    assert figure("N14", "frame mode 1 with pendulum") == pytest.approx(found[1], rel=1e-4)
    assert figure("N14", "frame mode 2 with pendulum") == pytest.approx(found[2], rel=1e-4)


def test_n14_the_excitation_misses_both_resonances():
    for number, excited in ((1, 1.9), (2, 6.8)):
        resonance = figure("N14", f"frame mode {number} with pendulum")
        ratio = excited / resonance
        xi = (0.01168, 0.00372)[number - 1]
        alone = 2 * xi / np.hypot(1 - ratio**2, 2 * xi * ratio)
        share = figure("N14", f"share of resonance at f_{number}")
        assert share == pytest.approx(alone, rel=0.25)
        assert share < 0.6


def test_e3_the_pseudoinverse_has_as_many_rows_as_there_are_samples():
    assert figure("E3", "rows needed") == 32 * 32


def test_e4_the_realization_reproduces_markov_parameters_only_with_the_positive_exponent():
    assert figure("E4", "error as printed") > 0.1
    assert figure("E4", "error with Sigma^(1/2)") < 1e-12
    rng = np.random.default_rng(3)
    observability, controllability = rng.standard_normal((6, 2)), rng.standard_normal((2, 6))
    hankel = observability @ controllability
    U, s, Vt = np.linalg.svd(hankel)
    for exponent, meets in ((0.5, True), (-0.5, False)):
        first = (U[:1, :2] * s[:2] ** exponent) @ (s[:2, None] ** exponent * Vt[:2, :1])
        assert np.isclose(first.item(), hankel[0, 0]) == meets


def test_w1_two_clamped_beams_make_the_storey():
    assert figure("W1", "one beam") == pytest.approx(12 * 2.0e11 * 2.917e-12 / 0.3**3)
    assert figure("W1", "storey") == pytest.approx(2 * figure("W1", "one beam"))
    assert figure("W1", "f_1, doubled") == pytest.approx(1.9488 * np.sqrt(2), rel=1e-4)


def test_w2_seventeen_hertz_folds_onto_fifteen():
    folded = figure("W2", "folded onto the top of the range")
    k = np.arange(50)
    np.testing.assert_allclose(
        np.cos(2 * np.pi * folded * k / 32), np.cos(2 * np.pi * 15 * k / 32), atol=1e-9
    )


def test_w4_the_tip_mass_gives_the_printed_inertia_about_the_hinge():
    tip, centre = figure("W4", "tip mass"), figure("W4", "centre of mass")
    rod = 0.083 - tip
    assert rod * 0.165**2 / 3 + tip * 0.165**2 == pytest.approx(8.32e-4)
    assert (rod * 0.0825 + tip * 0.165) / 0.083 == pytest.approx(centre)


def test_every_contradiction_has_its_own_id_a_title_and_a_derivation():
    found = contradictions()
    assert len({c.id for c in found}) == len(found) == 25
    for contradiction in found:
        assert len(contradiction.title) < 100
        assert len(contradiction.derivation) > 100
        assert "  " not in contradiction.derivation
        assert contradiction.equations


def test_an_unknown_figure_is_answered_with_those_there_are():
    with pytest.raises(KeyError, match="alpha"):
        figure("N1", "gamma")


def test_the_contradictions_survive_json():
    rows = [contradiction.to_dict() for contradiction in contradictions()]
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows
