"""Contradictions between the identified frame, the lumped frame and the pendulum."""

from __future__ import annotations

import numpy as np

from twin.modal import mac
from twin.paper import printed
from twin.paper.contradiction import Contradiction, Figure
from twin.paper.printed import Array, values
from twin.paper.recompute import absorber_model, identified_model, lumped_model, real_shapes


def identified_shapes() -> Array:
    """Return the shapes of (47)-(48), in phase and out of phase, (2, 2), one column a mode."""
    first, second = values(printed.AMPLITUDE)
    return np.array([[1.0, 1.0], [first, -second]])


def _second_storey(shapes: Array) -> Array:
    """Return k_2 / m_2 [1/s^2] that each shape needs at the frequencies of (47)-(48), (2,)."""
    ratio = shapes[1] / shapes[0]
    omega = 2 * np.pi * values(printed.FREQUENCY)
    return np.asarray(omega**2 * ratio / (ratio - 1))


def phase_of_pi() -> Contradiction:
    """The cut-off digits of pi."""
    phase, freq = printed.LUMPED_PHASE[1], printed.LUMPED_FREQUENCY[0]
    exact = float(lumped_model().undamped_modes().natural_freq[0])
    return Contradiction(
        "N8",
        "3.141 is pi cut off, while the numbers beside it are rounded",
        ("(9)", "(10)"),
        f"""Perfectly out of phase is pi = {np.pi:.5f}, rounded {np.pi:.3f}; (10) prints
        {phase.text}. The frequency {exact:.5f} Hz stands as {freq.text} in (9): rounded.""",
        (Figure("pi", float(np.pi), "rad"), Figure("f_1", exact, "Hz")),
    )


def shear_building() -> Contradiction:
    """The first shape of (47) against any shear building."""
    needed = _second_storey(identified_shapes())
    swapped = _second_storey(identified_shapes()[::-1])
    return Contradiction(
        "N9",
        "no two-storey shear building has the first shape of (47)",
        ("(3)-(6)", "(47)", "(48)"),
        f"""The second row of (K - w^2 M) phi = 0 with (3)-(6), for any two storey stiffnesses and
        masses, is rho = phi_2 / phi_1 = k_2 / (k_2 - w^2 m_2). In the first mode the floors move
        together, rho > 0, hence k_2 > w^2 m_2 and rho > 1: the upper floor moves more. (47) prints
        {printed.AMPLITUDE[0].text}. It would need k_2 / m_2 = {needed[0]:.0f} 1/s^2, a negative
        spring, where the second shape needs {needed[1]:.0f}. With the two floors interchanged the
        first ratio would be possible, but the modes would still ask for k_2 / m_2 of
        {swapped[0]:.0f} and {swapped[1]:.0f}.""",
        (
            Figure("k_2/m_2 by mode 1", float(needed[0]), "1/s^2"),
            Figure("k_2/m_2 by mode 2", float(needed[1]), "1/s^2"),
            Figure("k_2/m_2 by mode 1, floors swapped", float(swapped[0]), "1/s^2"),
            Figure("k_2/m_2 by mode 2, floors swapped", float(swapped[1]), "1/s^2"),
        ),
    )


def mass_ratio() -> Contradiction:
    """'Consistent' shapes."""
    shapes, lumped = identified_shapes(), real_shapes(lumped_model())
    ratio = float(-np.prod(shapes[1]))
    m_1, m_2 = values(printed.MASS)
    M = identified_model().M
    apart = np.abs(values(printed.FREQUENCY) / values(printed.LUMPED_FREQUENCY) - 1).max()
    alike, swapped = (
        np.diag(mac(other.astype(complex), lumped.astype(complex)))
        for other in (shapes, shapes[::-1])
    )
    return Contradiction(
        "N10",
        "the identified modes are not consistent with the lumped ones: the masses are reversed",
        ("(5)", "(9)", "(10)", "(47)", "(48)", "(50)", "Abstract"),
        f"""Shapes of a frame with lumped masses are orthogonal, m_1 + m_2 rho_1 rho_2 = 0, so that
        (47)-(48) need m_1 / m_2 = {ratio:.2f} and (50) has {M[0, 0] / M[1, 1]:.2f}; (5) has
        {m_1 / m_2:.2f}. The frequencies do agree
        within {100 * apart:.1f} %, the shapes do not: MAC with (9)-(10)
        is {alike[0]:.2f} and {alike[1]:.2f}. If the two accelerometers had been interchanged it
        would be {swapped[0]:.2f} and {swapped[1]:.2f}.""",
        (
            Figure("largest difference of frequencies", float(apart)),
            Figure("m_1/m_2 of (47)-(48)", ratio),
            Figure("m_1/m_2 of (50)", float(M[0, 0] / M[1, 1])),
            Figure("m_1/m_2 of (5)", float(m_1 / m_2)),
            Figure("MAC 1", float(alike[0])),
            Figure("MAC 2", float(alike[1])),
            Figure("MAC 1, floors swapped", float(swapped[0])),
            Figure("MAC 2, floors swapped", float(swapped[1])),
        ),
    )


def mass_matrix() -> Contradiction:
    """The off-diagonal mass and the total mass of (50)."""
    M = identified_model().M
    total, expected = float(M.sum()), float(values(printed.MASS).sum())
    beam = 54 / 420
    return Contradiction(
        "N11",
        "the mass matrix (50) is not one of floors in absolute coordinates, nor heavy enough",
        ("(1)", "(3)", "(5)", "(50)"),
        f"""The kinetic energy of two floors is a sum of squares of x_1' and x_2': M12 = 0. The
        second storey's own beams, of mass m_b and bent as clamped beams, add +{beam:.3f} m_b; (50)
        prints {printed.MASS_MATRIX[1].text} kg, which neither can give. Moved together, both floors
        weigh [1 1] M [1 1]^T = {total:.3f} kg by (50) and {expected:.2f} kg by (5), of which
        {100 * (1 - total / expected):.0f} % are missing.""",
        (
            Figure("moving mass of (50)", total, "kg"),
            Figure("moving mass of (5)", expected, "kg"),
            Figure("beam share of M_12", beam),
        ),
    )


def stiffness_matrix() -> Contradiction:
    """The springs that (51) consists of."""
    K = identified_model().K
    first, second, ground = K[0].sum(), -K[0, 1], K[1].sum()
    lumped = lumped_model().K
    give, lumped_give = np.linalg.inv(K)[0, 0], np.linalg.inv(lumped)[0, 0]
    k = -lumped[0, 1]
    return Contradiction(
        "N12",
        "K of (51) is not that of two equal storeys, and holds floor 2 to the ground",
        ("(4)", "(6)", "(7)", "(51)"),
        f"""Read as springs, (51) has storeys of K11 + K12 = {first:.1f} and -K12 = {second:.1f}
        N/m and a spring K22 + K12 = {ground:.1f} N/m from floor 2 to the ground, which the frame
        does not have; (6)-(7) have {k:.1f}, {k:.1f} and 0. One newton on floor 1 moves it by
        {1e3 * give:.2f} mm with (51) and {1e3 * lumped_give:.2f} mm with (6)-(7).""",
        (
            Figure("storey 1", float(first), "N/m"),
            Figure("storey 2", float(second), "N/m"),
            Figure("floor 2 to ground", float(ground), "N/m"),
            Figure("lumped storey", float(k), "N/m"),
            Figure("compliance of (51)", float(give), "m/N"),
            Figure("compliance of (6)-(7)", float(lumped_give), "m/N"),
        ),
    )


def inertia() -> Contradiction:
    """The pendulum's moment of inertia."""
    m, half, given = (
        number.value
        for number in (printed.PENDULUM_MASS, printed.HALF_LENGTH, printed.PENDULUM_INERTIA)
    )
    most, rod, pivot = m * half**2, m * half**2 / 3, m * (2 * half) ** 2 / 3
    twice = float(absorber_model().modes().natural_freq[0])
    once = float(absorber_model(given - most).modes().natural_freq[0])
    return Contradiction(
        "N13",
        "I_zz,3 is too large for the pendulum of (56), unless it is meant about the hinge",
        ("(56)",),
        f"""(56) adds m_3 l^2, so I_zz,3 is about the centre of mass, half-way down a length of
        2 l. With s from 0 to 2 l along a slender pendulum, the integral of s (2 l - s) dm >= 0
        limits the inertia about a centre at l to m_3 l^2 = {most:.3e} kg m^2 (two point masses at
        the ends); a rod has {rod:.3e}. (56) prints {printed.PENDULUM_INERTIA.text}, a radius of
        gyration of {1e3 * np.sqrt(given / m):.0f} mm with l = {1e3 * half:.1f} mm. About the hinge
        a rod has {pivot:.3e}, and {printed.PENDULUM_INERTIA.text} fits. Counting m_3 l^2 twice
        lowers the pendulum's frequency on the frame from {once:.3f} to {twice:.3f} Hz.""",
        (
            Figure("largest about the centre", most, "kg m^2"),
            Figure("rod about the centre", rod, "kg m^2"),
            Figure("rod about the hinge", pivot, "kg m^2"),
            Figure("radius of gyration", float(np.sqrt(given / m)), "m"),
            Figure("pendulum frequency as printed", twice, "Hz"),
            Figure("pendulum frequency, about the hinge", once, "Hz"),
        ),
    )


def excitation() -> Contradiction:
    """The 'worst case' of (57)."""
    model = absorber_model()
    freq = model.modes().natural_freq[1:]
    forced = values(printed.FORCE_FREQUENCY)
    shares = []
    for resonance, excited in zip(freq, forced, strict=True):
        grid = np.append(np.linspace(0.97 * resonance, 1.03 * resonance, 601), excited)
        dynamic = (
            -((2 * np.pi * grid[:, None, None]) ** 2) * model.M
            + 2j * np.pi * grid[:, None, None] * model.R
            + model.K
        )
        force = np.broadcast_to([[1.0], [0.0], [0.0]], (len(grid), 3, 1))
        answer = np.abs(np.linalg.solve(dynamic, force)[:, 0, 0])
        shares.append(float(answer[-1] / answer[:-1].max()))
    return Contradiction(
        "N14",
        "the excitation (57) is not the worst case for the model it is applied to",
        ("(47)", "(48)", "(50)-(51)", "(54)-(56)", "(57)"),
        f"""f_1 and f_2 of (57), {forced[0]} and {forced[1]} Hz, are the frequencies of (47)-(48).
        The simulated model is (50)-(51) with the pendulum, whose frame modes lie at
        {freq[0]:.3f} and {freq[1]:.3f} Hz: with the damping of (53) a force on floor 1 moves it at
        {forced[0]} Hz by {100 * shares[0]:.0f} % and at {forced[1]} Hz by {100 * shares[1]:.0f} %
        of the resonant amplitude.""",
        (
            Figure("frame mode 1 with pendulum", float(freq[0]), "Hz"),
            Figure("frame mode 2 with pendulum", float(freq[1]), "Hz"),
            Figure("share of resonance at f_1", shares[0]),
            Figure("share of resonance at f_2", shares[1]),
        ),
    )


def found() -> tuple[Contradiction, ...]:
    """Return the contradictions about the frame and the pendulum."""
    return (
        phase_of_pi(),
        shear_building(),
        mass_ratio(),
        mass_matrix(),
        stiffness_matrix(),
        inertia(),
        excitation(),
    )
