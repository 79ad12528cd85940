"""Types of the module; docs/guide/python.md has units and frames."""

from os import PathLike
from typing import Any, List, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Path = Union[str, PathLike[str]]

__version__: str

class Error(RuntimeError):
    """What the program prints when it ends with status 1."""

class Refused(Error):
    """A frame or an IMU sample that the estimator does not use; it stays usable."""

class State:
    """The estimate of one frame."""

    @property
    def t_ns(self) -> int: ...
    @property
    def health(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def has_pose(self) -> bool: ...
    @property
    def is_sound(self) -> bool: ...
    @property
    def position(self) -> NDArray[np.float64]: ...
    @property
    def quaternion(self) -> NDArray[np.float64]: ...
    @property
    def T_map_body(self) -> NDArray[np.float64]: ...
    @property
    def T_world_body(self) -> NDArray[np.float64]: ...
    @property
    def covariance(self) -> NDArray[np.float64]: ...
    @property
    def velocity(self) -> NDArray[np.float64]: ...
    @property
    def bias_gyro(self) -> NDArray[np.float64]: ...
    @property
    def bias_accel(self) -> NDArray[np.float64]: ...
    @property
    def tracked(self) -> int: ...
    @property
    def is_keyframe(self) -> bool: ...
    @property
    def resets(self) -> int: ...
    @property
    def total_ms(self) -> float: ...

class Estimator:
    """One configuration, fed sample by sample. A second thread that calls the same estimator waits."""

    def __init__(
        self,
        config: str,
        calibration: Path,
        *,
        imu_calibration: Optional[Path] = None,
        depth_scale: float = 0.0,
        map: bool = False,
    ) -> None: ...
    def add_imu(self, t_ns: Union[int, Sequence[int], NDArray[np.int64]], gyro: ArrayLike, accel: ArrayLike) -> None: ...
    def add_frame(
        self, t_ns: int, gray: NDArray[np.uint8], depth: Optional[NDArray[np.uint16]] = None
    ) -> State: ...
    @property
    def state(self) -> Optional[State]: ...
    @property
    def health(self) -> str: ...
    @property
    def covariance(self) -> Optional[NDArray[np.float64]]: ...
    @property
    def landmarks(self) -> NDArray[np.float64]: ...
    @property
    def time_offset_s(self) -> float: ...
    @property
    def config(self) -> str: ...

class Trajectory:
    """Poses with time stamps."""

    def __init__(
        self, t_ns: Union[Sequence[int], NDArray[np.int64]], position: ArrayLike, quaternion: ArrayLike
    ) -> None: ...
    @staticmethod
    def read(file: Path) -> Trajectory: ...
    def write(self, file: Path) -> None: ...
    def __len__(self) -> int: ...
    @property
    def t_ns(self) -> NDArray[np.int64]: ...
    @property
    def position(self) -> NDArray[np.float64]: ...
    @property
    def quaternion(self) -> NDArray[np.float64]: ...

class Run:
    """What one run gives."""

    @property
    def config(self) -> str: ...
    @property
    def trajectory(self) -> Trajectory: ...
    @property
    def landmarks(self) -> NDArray[np.float64]: ...
    @property
    def summary(self) -> str: ...
    @property
    def notes(self) -> List[str]: ...

def configurations() -> List[str]: ...
def run(
    dataset: Path,
    config: Optional[str] = None,
    map: bool = False,
    *,
    calibration: Optional[Path] = None,
    imu_calibration: Optional[Path] = None,
    depth_scale: float = 0.0,
    time_offset_s: Optional[float] = None,
    all_poses: bool = False,
    unchecked: bool = False,
    start_s: float = 0.0,
    duration_s: float = ...,
) -> Run: ...
def evaluate(
    reference: Union[Path, Trajectory],
    estimate: Union[Path, Trajectory],
    *,
    align: str = "se3",
    max_difference_s: float = 0.02,
    rpe_delta: float = 1.0,
    rpe_unit: str = "s",
) -> dict[str, Any]: ...
