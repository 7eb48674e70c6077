"""The controller as one C99 file that needs no library, not even the mathematical one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.control.controller import Controller

Array = NDArray[np.float64]

_TEMPLATE = """\
/* Discrete-time LQG controller of a pendulum absorber, written by frame-twin.
 *
 * Call controller_step every {dt!r} s ({rate:.10g} Hz) with
{inputs}
 * and let the motor hold the torque *u [N m] until the next one. Designed for {delay:g} samples
 * between reading and acting. The estimator runs all the time; controller_switch(1) switches the
 * torque on with a soft start of {ramp} samples, controller_switch(0) off. C99, no library.
 */

#define STATES {n}
#define MEASUREMENTS {m}
#define ESTIMATES {e}
#define RAMP {ramp}.0

static const double TORQUE_LIMIT = {limit};

/* Rows: the next state, then the torque. Columns: state, y, f. */
static const double LAW[STATES + 1][STATES + MEASUREMENTS + 1] = {{
{law}
}};

static const double TORQUE_TO_STATE[STATES] = {{ {B_u} }};

/* From the state after a step to {estimates}. */
static const double ESTIMATE[ESTIMATES][STATES] = {{
{E}
}};

static double state[STATES];
static double steps;
static int on;

void controller_reset(void);
void controller_switch(int switched_on);
void controller_step(const double *y, double f, double *u);
void controller_estimate(double *estimate);

void controller_reset(void)
{{
    int i;
    for (i = 0; i < STATES; i++) state[i] = 0.0;
    steps = 0.0;
    on = 0;
}}

void controller_switch(int switched_on)
{{
    on = switched_on;
    steps = 0.0;
}}

void controller_step(const double *y, double f, double *u)
{{
    double next[STATES + 1];
    double torque = 0.0;
    int i, j;
    for (i = 0; i <= STATES; i++) {{
        double sum = LAW[i][STATES + MEASUREMENTS] * f;
        for (j = 0; j < STATES; j++) sum += LAW[i][j] * state[j];
        for (j = 0; j < MEASUREMENTS; j++) sum += LAW[i][STATES + j] * y[j];
        next[i] = sum;
    }}
    if (on) {{
        torque = next[STATES];
        if (steps < RAMP) steps += 1.0;
        if (steps < RAMP) torque *= steps / RAMP;
        if (torque > TORQUE_LIMIT) torque = TORQUE_LIMIT;
        if (torque < -TORQUE_LIMIT) torque = -TORQUE_LIMIT;
    }}
    for (i = 0; i < STATES; i++) state[i] = next[i] + TORQUE_TO_STATE[i] * torque;
    *u = torque;
}}

void controller_estimate(double *estimate)
{{
    int i, j;
    for (i = 0; i < ESTIMATES; i++) {{
        estimate[i] = 0.0;
        for (j = 0; j < STATES; j++) estimate[i] += ESTIMATE[i][j] * state[j];
    }}
}}
"""


def c_source(controller: Controller) -> str:
    """Return the file's text: ``void controller_step(const double *y, double f, double *u)``.

    ``controller_reset``, ``controller_switch`` and ``controller_estimate`` stand beside it.
    """
    c = controller
    unit = {"acc": "m/s^2", "ang": "rad", "for": "N"}
    lines = [f" *   y[{i}] {name} [{unit[name[:3]]}]," for i, name in enumerate(c.measurements)]
    lines.append(f" *   f {c.known_input} [{unit[c.known_input[:3]]}]")
    law = np.block([[c.A, c.B_y, c.B_f[:, None]], [c.C[None], c.D_y[None], np.array([[c.D_f]])]])
    return _TEMPLATE.format(
        dt=c.dt,
        rate=c.rate_hz,
        inputs="\n".join(lines),
        delay=c.delay,
        ramp=c.ramp_samples,
        limit=repr(c.torque_limit),
        n=len(c.A),
        m=len(c.measurements),
        e=len(c.estimates),
        law=_rows(law),
        B_u=_numbers(c.B_u),
        estimates=", ".join(c.estimates),
        E=_rows(c.E),
    )


def _numbers(values: Array) -> str:
    return ", ".join(repr(float(value)) for value in values)


def _rows(matrix: Array) -> str:
    return ",\n".join(f"    {{ {_numbers(row)} }}" for row in matrix)
