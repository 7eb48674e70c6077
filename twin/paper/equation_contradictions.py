"""Equations that contradict each other by shape or exponent, and words that contradict numbers."""

from __future__ import annotations

import numpy as np

from twin.paper import printed
from twin.paper.checks import realization_error
from twin.paper.contradiction import Contradiction, Figure
from twin.paper.recompute import INPUTS, OUTPUTS, lumped_model, storey_stiffness


def observer_direct() -> Contradiction:
    """The first observer Markov parameter."""
    columns = INPUTS + OUTPUTS
    return Contradiction(
        "E1",
        "the first observer Markov parameter of (19) does not fit the sum (17)",
        ("(17)", "(19)", "(26)", "(27)"),
        f"""(17) multiplies Y-bar_0 with v = [u; y], and the text gives every Y-bar_k the shape
        m x (r + m), here {OUTPUTS} x {columns}; (19) sets Y-bar_0 = D, {OUTPUTS} x {INPUTS}.
        (26)-(27) pair it with u alone. Either Y-bar_0 = [D 0] in (17), or (17) starts at j = 1 and
        adds D u(k), as (21) does.""",
        (
            Figure("columns of Y-bar_0 in (17)", columns),
            Figure("columns of D", INPUTS),
        ),
    )


def observer_gain_start() -> Contradiction:
    """The first observer gain Markov parameter."""
    return Contradiction(
        "E2",
        "the observer gain Markov parameters have no member 0",
        ("(20)", "(30)"),
        f"""(20) sets Y^0_0 = D, which is m x r, here {OUTPUTS} x {INPUTS}, in a sequence of m x m
        matrices, {OUTPUTS} x {OUTPUTS}. C A^(k-1) G starts at k = 1, as (30) does; nothing uses
        Y^0_0.""",
        (Figure("columns of Y^0_k", OUTPUTS), Figure("columns of D", INPUTS)),
    )


def pseudoinverse() -> Contradiction:
    """The shape of a pseudoinverse."""
    samples = round(printed.SAMPLING.value * printed.DURATION.value)
    return Contradiction(
        "E3",
        "V_p^+ of (28) has been given the shape of L-bar_p",
        ("(24)", "(27)", "(28)"),
        f"""V_p is (r + (r + m) p) x l, so its pseudoinverse is l x (r + (r + m) p), and
        Y V_p^+ needs its l = {samples} rows; the text says m x (r + (r + m) p), {OUTPUTS} rows.""",
        (Figure("rows needed", samples), Figure("rows stated", OUTPUTS)),
    )


def realization() -> Contradiction:
    """The exponents of (38)."""
    as_printed, corrected = realization_error(-0.5), realization_error(0.5)
    return Contradiction(
        "E4",
        "B, G and C of (38) carry Sigma^(-1/2) where (36) needs Sigma^(1/2)",
        ("(18)", "(36)", "(38)"),
        f"""N(0) = R Sigma S^T is observability times controllability matrix; its first block is
        Y_1 = C B = E_m^T R Sigma S^T E_r. The B and C of (38) give E_m^T R Sigma^-1 S^T E_r
        instead. On the frame of (50), (51), (53) hit on floor 1, the Markov parameters of (38) as
        printed are wrong by {100 * as_printed:.0f} % of the largest; with Sigma^(1/2) by
        {corrected:.0e}. The exponents of A in (38) are right.""",
        (
            Figure("error as printed", as_printed),
            Figure("error with Sigma^(1/2)", corrected),
        ),
    )


def block_selectors() -> Contradiction:
    """The transposes of (39)-(40)."""
    return Contradiction(
        "E5",
        "E_m^T and E_(r+m)^T of (39)-(40) are transposed once too often",
        ("(38)", "(39)", "(40)"),
        """(39) reads E_m^T = [I O .. O]^T, alpha m rows and m columns. C = E_m^T R Sigma.. of (38)
        needs m rows and alpha m columns, and S^T E_(r+m) needs beta (r + m) rows: E_m and
        E_(r+m), not their transposes, are [I O .. O]^T.""",
    )


def pendulum_stiffness() -> Contradiction:
    """The shapes of M_3 and K_3."""
    return Contradiction(
        "E6",
        "one B_3 cannot place both the 2 x 2 mass and the scalar stiffness of the pendulum",
        ("(55)", "(56)"),
        """B_3^T M_3 B_3 with M_3 of 2 x 2 needs B_3 of 2 x 3, picking x_2 and theta;
        B_3^T K_3 B_3 with the scalar K_3 = m_3 g l needs 1 x 3, picking theta. Meant is
        K_3 = diag(0, m_3 g l), R_3 = 0 of the same shape.""",
        (Figure("rows of B_3 for M_3", 2), Figure("rows of B_3 for K_3", 1)),
    )


def modal_vector() -> Contradiction:
    """A shape defined by itself."""
    theta = printed.PHASE[0]
    return Contradiction(
        "E7",
        "the text under (48) defines the amplitudes by themselves",
        ("(8)", "(47)", "(48)"),
        f"""It reads rho_j = e^(i Theta_j) rho_j, which holds only for Theta_j = 0, while (47)
        prints {theta.text} and (48) {printed.PHASE[1].text}. By (8) the left side is phi_j.""",
        (Figure("Theta_1", theta.value, "rad"),),
    )


def beam_stiffness() -> Contradiction:
    """One beam or two."""
    one, two = storey_stiffness(1), storey_stiffness(2)
    doubled = lumped_model(2 * two).undamped_modes().natural_freq
    return Contradiction(
        "W1",
        "24 E J / L^3 is the stiffness of a storey, not 'of each flexible beam'",
        ("(6)", "(7)", "(9)", "(10)"),
        f"""A clamped-clamped beam pushed sideways has 12 E J / L^3 = {one:.2f} N/m; (7) is two of
        them in parallel, {two:.2f} N/m, and (9)-(10) follow with it as the storey's k. Were it each
        beam's, a storey would have twice that and the frequencies would be {doubled[0]:.3f} and
        {doubled[1]:.3f} Hz.""",
        (
            Figure("one beam", one, "N/m"),
            Figure("storey", two, "N/m"),
            Figure("f_1, doubled", float(doubled[0]), "Hz"),
            Figure("f_2, doubled", float(doubled[1]), "Hz"),
        ),
    )


def filter_at_nyquist() -> Contradiction:
    """The cut-off frequency."""
    rate, cut, top = (n.value for n in (printed.SAMPLING, printed.CUT_OFF, printed.FREQUENCY_RANGE))
    alias = rate - top
    passed = float(1 / np.sqrt(1 + (alias / cut) ** 16))
    return Contradiction(
        "W2",
        "a low-pass filter with its cut-off at the Nyquist frequency removes nothing",
        ("Sec. V",),
        f"""At {rate:.0f} Hz nothing above {rate / 2:.0f} Hz is left to be filtered. Applied before
        sampling, a cut-off of {cut:.0f} Hz lets {alias:.0f} Hz through (an eighth-order Butterworth
        passes {100 * passed:.0f} % of it), which sampling folds onto {top:.0f} Hz, inside the range
        that is called 'correctly captured'.""",
        (
            Figure("folded onto the top of the range", alias, "Hz"),
            Figure("passed by an eighth-order Butterworth", passed),
        ),
    )


def ground_force() -> Contradiction:
    """A force where there is no coordinate."""
    return Contradiction(
        "W3",
        "F_e acts on the ground, which has no coordinate in (54)",
        ("(54)", "(55)", "(57)", "Fig. 8"),
        """x = [x_1 x_2 theta]: a force on the ground does no work on any of them, so T_e = 0 if the
        ground is held, as in the hammer test behind (50)-(51). If it moves, (54) lacks its
        coordinate, its mass (not in (55)) and the load it takes, and with x relative to it the
        input is its acceleration, not the force of the load cell. T_e is not printed, so that (60)
        cannot be recomputed without choosing it.""",
    )


def tip_mass() -> Contradiction:
    """The centre of mass of the pendulum."""
    m, half, given = (
        number.value
        for number in (printed.PENDULUM_MASS, printed.HALF_LENGTH, printed.PENDULUM_INERTIA)
    )
    # A uniform rod and a point mass at its end: I = (m - tip) (2 l)^2 / 3 + tip (2 l)^2.
    tip = 1.5 * (given / (2 * half) ** 2 - m / 3)
    centre = half * (1 + tip / m)
    return Contradiction(
        "W4",
        "a pendulum with a mass on its tip does not have its centre at half its length",
        ("Sec. VI", "(56)"),
        f"""The text puts 'an additional mass concentrated on the tip'; m_3 l and m_3 g l of (56)
        take the centre of mass at half the length, which leaves a uniform rod no tip mass at all.
        A rod of that length with the mass m_3 and, about its hinge, I_zz,3 has
        {1e3 * tip:.1f} g on its tip and its centre {1e3 * centre:.1f} mm from the hinge, not
        {1e3 * half:.1f} mm.""",
        (Figure("tip mass", tip, "kg"), Figure("centre of mass", centre, "m")),
    )


def found() -> tuple[Contradiction, ...]:
    """Return the contradictions among equations and between words and numbers."""
    return (
        observer_direct(),
        observer_gain_start(),
        pseudoinverse(),
        realization(),
        block_selectors(),
        pendulum_stiffness(),
        modal_vector(),
        beam_stiffness(),
        filter_at_nyquist(),
        ground_force(),
        tip_mass(),
    )
