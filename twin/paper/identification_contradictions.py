"""Contradictions among the identified numbers, (41) and (47)-(53)."""

from __future__ import annotations

import numpy as np

from twin.paper import printed
from twin.paper.contradiction import Contradiction, Figure
from twin.paper.normalisation import SIGNS, exact_matrices, largest_passive_phase, nearest_scale
from twin.paper.printed import Array, values
from twin.paper.recompute import (
    fitted_coefficients,
    identified_model,
    implied_coefficients,
    lumped_model,
    proportional_matrix,
    real_shapes,
    undamped_frequencies,
)
from twin.paper.rounding import misfit

MATRICES = printed.MASS_MATRIX + printed.STIFFNESS_MATRIX


def coefficients() -> Contradiction:
    """(49) against (47)-(48)."""
    alpha, beta = fitted_coefficients(values(printed.MODAL))
    omega = 2 * np.pi * values(printed.FREQUENCY)
    a, b = values(printed.PROPORTIONAL)
    xi = (a / omega + b * omega) / 2
    miss = misfit(
        lambda x, _: fitted_coefficients(x),
        printed.FREQUENCY + printed.DAMPING,
        printed.PROPORTIONAL,
    )
    return Contradiction(
        "N1",
        "alpha and beta of (49) are not those of the modes (47)-(48)",
        ("(42)-(45)", "(47)", "(48)", "(49)"),
        f"""With two modes (42)-(45) are two equations for two unknowns,
        (alpha / w_j + beta w_j) / 2 = xi_j. The printed f and xi give alpha = {alpha:.4f} 1/s and
        beta = {beta:.4e} s; (49) prints {printed.PROPORTIONAL[0].text} and
        {printed.PROPORTIONAL[1].text}, which would belong to xi = {xi[0]:.4f} and {xi[1]:.4f}
        instead of {printed.DAMPING[0].text} and {printed.DAMPING[1].text}. With every input moved
        inside its rounding interval the nearest result still misses (49) by {miss:.0f} half units
        of the last digit.""",
        (
            Figure("alpha", float(alpha), "1/s"),
            Figure("beta", float(beta), "s"),
            Figure("xi_1 of (49)", float(xi[0])),
            Figure("xi_2 of (49)", float(xi[1])),
            Figure("misfit", miss, "half units"),
        ),
    )


def proportional() -> Contradiction:
    """(53) against (46) with (49)."""
    matrices = values(MATRICES)
    R = proportional_matrix(values(printed.PROPORTIONAL), matrices)
    (alpha, beta), residual = implied_coefficients(
        values(printed.IMPROVED_DAMPING_MATRIX), matrices
    )
    miss = misfit(
        lambda x, _: proportional_matrix(x[:2], x[2:]),
        printed.PROPORTIONAL + MATRICES,
        printed.IMPROVED_DAMPING_MATRIX,
    )
    from_modes = misfit(
        lambda x, _: proportional_matrix(fitted_coefficients(x), x[4:]),
        printed.FREQUENCY + printed.DAMPING + MATRICES,
        printed.IMPROVED_DAMPING_MATRIX,
    )
    first, second, third = (number.text for number in printed.IMPROVED_DAMPING_MATRIX)
    return Contradiction(
        "N2",
        "R of (53) is not alpha M + beta K with the alpha and beta of (49)",
        ("(46)", "(49)", "(50)", "(51)", "(53)"),
        f"""With (49)-(51), alpha M + beta K = [{R[0]:.4f}, {R[1]:.4f}; {R[1]:.4f}, {R[2]:.4f}];
        (53) prints [{first}, {second}; {second}, {third}], off by {miss:.0f} half units however
        the inputs are rounded. The three printed entries do agree with one pair,
        alpha = {alpha:.4f} 1/s and beta = {beta:.3e} s (largest residual {residual:.1e}), and that
        pair follows from (47)-(48) within rounding (misfit {from_modes:.2f} half units). So (53)
        was computed from (47)-(48), and (49) belongs to neither.""",
        (
            Figure("R_11 by (49)", float(R[0]), "N s/m"),
            Figure("R_12 by (49)", float(R[1]), "N s/m"),
            Figure("R_22 by (49)", float(R[2]), "N s/m"),
            Figure("alpha of (53)", float(alpha), "1/s"),
            Figure("beta of (53)", float(beta), "s"),
            Figure("residual", residual, "N s/m"),
            Figure("misfit", miss, "half units"),
            Figure("misfit from (47)-(48)", from_modes, "half units"),
        ),
    )


def _correlation(a: Array, metric: Array, b: Array) -> float:
    return float(a @ metric @ b / np.sqrt((a @ metric @ a) * (b @ metric @ b)))


def frequencies() -> Contradiction:
    """(50)-(51) against (47)-(48)."""
    model = identified_model()
    freq = undamped_frequencies(values(MATRICES))
    ratio = real_shapes(model)[1]
    miss = misfit(lambda x, _: undamped_frequencies(x), MATRICES, printed.FREQUENCY)
    first, second = np.array([1.0, 1.0]), np.array([1.0, -1.0])
    first[1], second[1] = np.array([1, -1]) * values(printed.AMPLITUDE)
    in_mass = _correlation(first, model.M, second)
    in_stiffness = _correlation(first, model.K, second)
    return Contradiction(
        "N3",
        "M and K of (50)-(51) do not have the modes of (47)-(48)",
        ("(41)", "(47)", "(48)", "(50)", "(51)"),
        f"""(41) returns matrices whose modes are the ones it was given. det(K - w^2 M) = 0 with
        (50)-(51) gives {freq[0]:.3f} and {freq[1]:.3f} Hz; (47)-(48) print
        {printed.FREQUENCY[0].text} and {printed.FREQUENCY[1].text} Hz, {miss:.0f} half units away
        at best. The shapes are [1, {ratio[0]:.3f}] and [1, {ratio[1]:.3f}]; printed are
        [1, {printed.AMPLITUDE[0].text}] and [1, -{printed.AMPLITUDE[1].text}]. The printed shapes
        are not orthogonal either: normalised cross product {in_mass:.3f} through M and
        {in_stiffness:.3f} through K, where 0 is due. N5 shows where this comes from.""",
        (
            Figure("f_1 of (50)-(51)", float(freq[0]), "Hz"),
            Figure("f_2 of (50)-(51)", float(freq[1]), "Hz"),
            Figure("shape 1 of (50)-(51)", float(ratio[0])),
            Figure("shape 2 of (50)-(51)", float(ratio[1])),
            Figure("cross product through M", in_mass),
            Figure("cross product through K", in_stiffness),
            Figure("misfit", miss, "half units"),
        ),
    )


def damping() -> Contradiction:
    """(52) against (47)-(48) and (53)."""
    poles = np.linalg.eigvals(identified_model(printed.DAMPING_MATRIX).state_matrix())
    oscillating = poles[poles.imag > 0][0]
    xi = float(-oscillating.real / abs(oscillating))
    real = np.sort(poles[poles.imag == 0].real)
    times = printed.DAMPING_MATRIX[0].value / printed.IMPROVED_DAMPING_MATRIX[0].value
    return Contradiction(
        "N4",
        "R of (52) stops the vibration that (47)-(48) measured",
        ("(41)", "(47)", "(48)", "(50)-(52)", "(53)", "(55)"),
        f"""The poles of (50)-(52) are one pair with xi = {xi:.3f} and two real ones,
        {real[0]:.1f} and {real[1]:.1f} 1/s: the first mode dies in one swing and the second does
        not swing at all, where (47)-(48) print {printed.DAMPING[0].text} and
        {printed.DAMPING[1].text}. R11 is {times:.0f} times that of (53). Both matrices are called
        R-hat, and (55) takes 'the identified damping matrix' without saying which. The text blames
        noise; N5 shows a systematic reason.""",
        (
            Figure("xi_1 of (50)-(52)", xi),
            Figure("first real pole", float(real[0]), "1/s"),
            Figure("second real pole", float(real[1]), "1/s"),
            Figure("(52) over (53), R_11", times),
        ),
    )


def scale() -> Contradiction:
    """(41) applied outside its conditions."""
    best = min((nearest_scale(sign) for sign in SIGNS), key=lambda found: found.misfit)
    return Contradiction(
        "N5",
        "(50)-(52) are (41) applied to eigenvectors that do not have the scale it needs",
        ("(41)", "(47)", "(48)", "(50)-(52)"),
        f"""(41) holds for eigenvectors Phi = [W; W Lambda] scaled to
        Phi^T [[R, M], [M, 0]] Phi = I, and then also W W^T = 0, a condition the paper leaves out.
        The shapes, frequencies and damping ratios of (47)-(48) fix W up to one complex scale a
        mode, four real numbers; with them (41) meets the nine entries of (50)-(52) within
        {100 * best.relative:.2f} % of their matrix's largest from the digits as printed, and to the
        last digit (misfit {best.misfit:.2f} half units) from inputs inside their rounding interval.
        That W has |W W^T| / |W|^2 = {best.orthogonality:.2f} instead of 0. So (50)-(52) do come
        from (47)-(48), through a W for which (41) is not true: this is the common cause of the
        other frequencies (N3) and of the damping (N4).""",
        (
            Figure("misfit", best.misfit, "half units"),
            Figure("relative miss, digits as printed", best.relative),
            Figure("|W W^T| / |W|^2", best.orthogonality),
        ),
    )


def conjugate() -> Contradiction:
    """The signs of the two phases."""
    misses = {sign: nearest_scale(sign).misfit for sign in SIGNS}
    as_printed, turned = misses[(1, 1)], misses[(-1, 1)]
    return Contradiction(
        "N6",
        "the phases of (47) and (48) belong to a pole and to the conjugate of a pole",
        ("(41)", "(47)", "(48)", "(50)-(52)"),
        f"""A shape and its complex conjugate belong to a pole and its conjugate, so that the two
        printed phases must be taken at poles of one sign. With both as printed, (41) misses
        (50)-(52) by {as_printed:.0f} half units whatever the scale of the eigenvectors; with the
        sign of {printed.PHASE[0].text} turned it meets all nine entries ({turned:.2f}). One of the
        two shapes was printed for the conjugate pole.""",
        (
            Figure("misfit as printed", as_printed, "half units"),
            Figure("misfit, Theta_1 turned", turned, "half units"),
            Figure("misfit, Theta_2 turned", misses[(1, -1)], "half units"),
            Figure("misfit, both turned", misses[(-1, -1)], "half units"),
        ),
    )


def phase() -> Contradiction:
    """The phase of (47) against its damping ratios."""
    xi = values(printed.DAMPING)
    limits = [
        float(largest_passive_phase(model.M, model.K, xi)[0])
        for model in (identified_model(), lumped_model())
    ]
    largest = max(limits)
    exact = [exact_matrices(sign) for sign in SIGNS]
    no_mass = sum(bool(np.linalg.eigvalsh(M)[0] < 0) for M, _, _ in exact)
    no_damper = sum(
        bool(np.linalg.eigvalsh(M)[0] > 0 > np.linalg.eigvalsh(R)[0]) for M, _, R in exact
    )
    theta = printed.PHASE[0]
    return Contradiction(
        "N7",
        "no viscous damping as light as (47)-(48) turns a shape by the phase of (47)",
        ("(47)", "(48)", "(53)"),
        f"""Viscous damping that only dissipates turns shapes by modal coupling r with
        r^2 <= (2 xi_1 w_1)(2 xi_2 w_2). At that limit the first shape is turned by
        {limits[0]:.4f} rad with (50)-(51) and {limits[1]:.4f} rad with the lumped model; (47)
        prints {theta.text} rad, {abs(theta.value) / largest:.0f} times the larger. Accordingly the
        M, K and R that have exactly the modes of (47)-(48) (W W^T = 0 fixes them up to a factor)
        are no structure's: of the {len(exact)} ways to give the two phases their signs, {no_mass}
        make M indefinite and {no_damper} give R a negative eigenvalue. With the proportional
        damping of (53) the phases are 0 and pi. The phase is the measurement's, not the
        frame's.""",
        (
            Figure("largest phase, (50)-(51)", limits[0], "rad"),
            Figure("largest phase, lumped", limits[1], "rad"),
            Figure("printed over largest", abs(theta.value) / largest),
            Figure("sign choices with indefinite M", no_mass),
            Figure("sign choices with negative R", no_damper),
        ),
    )


def found() -> tuple[Contradiction, ...]:
    """Return the contradictions among the identified numbers."""
    return (
        coefficients(),
        proportional(),
        frequencies(),
        damping(),
        scale(),
        conjugate(),
        phase(),
    )
