"""The public names for checkers of types, which do not see what is imported on first use."""

from bearing_twin.base.errors import BearingTwinError as BearingTwinError
from bearing_twin.base.errors import IntegrationError as IntegrationError
from bearing_twin.base.errors import LogError as LogError
from bearing_twin.base.errors import MissingInterfacesError as MissingInterfacesError
from bearing_twin.base.errors import SceneError as SceneError
from bearing_twin.base.errors import StatisticError as StatisticError
from bearing_twin.base.errors import StudyError as StudyError
from bearing_twin.log.export import export_log as export_log
from bearing_twin.log.raw_log import recover as recover
from bearing_twin.log.run_log import read_log as read_log
from bearing_twin.log.run_log import write_log as write_log
from bearing_twin.log.study_log import read_study as read_study
from bearing_twin.log.study_log import write_study as write_study
from bearing_twin.run.equilibrium import equilibrium as equilibrium
from bearing_twin.run.scene import load_scene as load_scene
from bearing_twin.run.scene import parse_scene as parse_scene
from bearing_twin.run.scene import scene_names as scene_names
from bearing_twin.run.simulation import simulate as simulate
from bearing_twin.uq.run import run_study as run_study
from bearing_twin.uq.study import load_study as load_study
from bearing_twin.uq.study import parse_study as parse_study
from bearing_twin.uq.study import study_names as study_names

__version__: str
