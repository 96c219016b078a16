"""Where the stable names of the package live, for type checkers and editors."""

from pickcli.api.planner import Planner as Planner
from pickcli.cell.cell import Cell as Cell
from pickcli.cell.cell_file import load_cell as load_cell
from pickcli.cell.item import Item as Item
from pickcli.cell.shapes import Body as Body
from pickcli.cell.shapes import Shape as Shape
from pickcli.cell.shapes import ShapeKind as ShapeKind
from pickcli.cell.shapes import box as box
from pickcli.errors import ApcError as ApcError
from pickcli.errors import DamagedError as DamagedError
from pickcli.errors import InputError as InputError
from pickcli.errors import NoPlanError as NoPlanError
from pickcli.errors import Reason as Reason
from pickcli.errors import RejectedError as RejectedError
from pickcli.errors import StaleError as StaleError
from pickcli.errors import UnknownNameError as UnknownNameError
from pickcli.geometry import pose as pose
from pickcli.motion.event import Event as Event
from pickcli.motion.path import JointPath as JointPath
from pickcli.motion.plan import Certificate as Certificate
from pickcli.motion.plan import Grasp as Grasp
from pickcli.motion.plan import Plan as Plan
from pickcli.motion.plan_file import read_plan as read_plan
from pickcli.motion.plan_file import write_plan as write_plan
from pickcli.motion.segment import Segment as Segment
from pickcli.motion.segment import SegmentKind as SegmentKind
from pickcli.motion.trajectory import Trajectory as Trajectory
from pickcli.perception.items.perceived_file import Perceived as Perceived
from pickcli.perception.items.perceived_file import read_perceived as read_perceived
from pickcli.perception.items.perceived_file import write_perceived as write_perceived
from pickcli.random_scenes.make_scene import make_scene as make_scene
from pickcli.scene.cloud import Cloud as Cloud
from pickcli.scene.scene import PlacedItem as PlacedItem
from pickcli.scene.scene import PoseNoise as PoseNoise
from pickcli.scene.scene import Scene as Scene
from pickcli.scene.scene_file import read_scene as read_scene
from pickcli.scene.scene_file import write_scene as write_scene
from pickcli.simulation.execution import Execution as Execution
from pickcli.trial.order import Order as Order
from pickcli.trial.order_file import read_order as read_order

__version__: str
__all__: list[str]
