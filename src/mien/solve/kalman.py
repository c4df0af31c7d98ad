"""A bank of constant-velocity Kalman filters, one a coefficient."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class KalmanConfig:
    """How restless the coefficients are and how far the measurements can be trusted."""

    process: float = 0.05
    """Standard deviation of the change of a coefficient's speed within one frame, coefficient a frame."""
    measurement: float = 0.02
    """Standard deviation of one measurement of a coefficient."""
    rate: float = 30.0
    """Frames a second that `process` is meant for; other intervals are scaled from it."""


@dataclass(frozen=True)
class KalmanState:
    """What is believed of every coefficient."""

    mean: Float[np.ndarray, "k 2"]
    """Position, and speed a second."""
    covariance: Float[np.ndarray, "k 2 2"]

    @property
    def values(self) -> Float[np.ndarray, " k"]:
        """The filtered coefficients."""
        return self.mean[:, 0]


def start(measurement: Float[np.ndarray, " k"], config: KalmanConfig = KalmanConfig()) -> KalmanState:
    """The state after a first measurement: at rest there, the speed unknown to the scale of `process` over 3 frames."""
    covariance = np.zeros((len(measurement), 2, 2))
    covariance[:, 0, 0] = config.measurement**2
    covariance[:, 1, 1] = (3 * config.process * config.rate) ** 2
    return KalmanState(np.stack([measurement, np.zeros(len(measurement))], axis=1), covariance)


def step(
    state: KalmanState, measurement: Float[np.ndarray, " k"], dt: float, config: KalmanConfig = KalmanConfig()
) -> KalmanState:
    """One prediction over `dt` seconds and one update; a new state (Li et al. 2013, sec. 4.2).

    The paper gives "a process noise of 0.05 and measurement noise of 0.02" with no units. They are read here as
    standard deviations in units of the coefficient and of one frame at 30 Hz: read a second, 0.05 would lag a blink by
    a third of a second and more. The process is white acceleration, so its covariance over dt is
    q [[dt^3/3, dt^2/2], [dt^2/2, dt]] with q = (process rate)^2 rate. Where the measurement is NaN only the
    prediction is made.

    Raises:
        ValueError: `dt` is not positive, or the measurement's length is not the state's.
    """
    if dt <= 0:
        raise ValueError(f"dt: expected > 0 seconds, got {dt}")
    if measurement.shape != state.values.shape:
        raise ValueError(f"measurement: expected shape {state.values.shape}, got {measurement.shape}")
    advance = np.array([[1.0, dt], [0.0, 1.0]])
    density = (config.process * config.rate) ** 2 * config.rate
    noise = density * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    mean = state.mean @ advance.T
    covariance = advance @ state.covariance @ advance.T + noise
    seen = np.isfinite(measurement)
    gain = covariance[:, :, 0] / (covariance[:, :1, 0] + config.measurement**2) * seen[:, None]
    surprise = np.where(seen, measurement - mean[:, 0], 0.0)
    mean = mean + gain * surprise[:, None]
    covariance = covariance - gain[:, :, None] * covariance[:, None, 0, :]
    return KalmanState(mean, 0.5 * (covariance + covariance.transpose(0, 2, 1)))
