"""The one description of the OpenMANIPULATOR-X that is not its DH table: limits, poses, masses, servos, thresholds.

Data only; lengths in mm, angles in rad, masses in kg. What is not the maker's has its reason beside it.
"""

from math import asin, atan2, hypot, pi, radians

# ---- joints and named poses ----


class Limits(tuple):
    """One (low, high) a joint, shown in signatures by its name."""

    def __repr__(self) -> str:
        return "omx.LIMITS" if self == LIMITS else super().__repr__()

    def _repr_pretty_(self, printer, cycle) -> None:
        printer.text(super().__repr__())


#: Joint limits (rad), from the maker's current URDF: one (low, high) a joint.
LIMITS = Limits(((-pi, pi), (-1.5, 1.5), (-1.5, 1.4), (-1.7, 1.97)))

#: Where the frames stop the joints (rad): the widest limits that anyone publishes for this arm.
STOPS = ((-pi, pi), (-2.05, 1.571), (-1.571, 1.53), (-1.8, 2.0))

#: All joints at zero: the tool points forward, (274, 0, 204.765) mm.
ZERO = (0.0, 0.0, 0.0, 0.0)

#: The maker's home pose: the arm folded back over itself, tool level. Parking passes it, so that the hand comes down
#: from above.
HOME = (0.0, -1.05, 0.35, 0.70)

#: Where the arm lies when it is parked, folded together: least to fall when the torque goes off. Check it on yours.
REST = (0.0, -1.45, 1.32, 0.2)

#: The lengths of the course's drawing, for which the text, the labs' points and the printed tables are made.
COURSE_LENGTHS = {"L1": 77.0, "L2": 130.0, "L3": 124.0, "L4": 126.0, "delta": asin(24 / 130)}

#: What differs in the maker's URDF: a shoulder 0.5 mm lower, and an upper arm that is 128 up and 24 forward.
MAKER_LENGTHS = {"L1": 76.5, "L2": hypot(128, 24), "delta": atan2(24, 128)}

#: The maker's base frame lies this far (mm) behind the axis of joint 1, where the book's base frame is.
BASE_OFFSET = 12.0

# ---- gripper ----

#: The fingers travel -10 .. 19 mm each; a servo angle of +1 rad closes them by 11.5 mm each.
FINGERS, FINGER_PER_RAD = (-10.0, 19.0), -11.5
#: The gap (mm) between the pads at servo angle 0.
OPENING_AT_ZERO = 42.0
#: Torque (Nm) at the gripper's servo for each N with which either pad presses: the pads close by 23 mm a rad.
GRIP_TORQUE_PER_N = 2 * -FINGER_PER_RAD / 1000
#: How hard (N) the gripper may press, and how hard it does unless told otherwise: enough for the payload on rubber.
GRIP_FORCES, GRIP_FORCE = (2.0, 40.0), 10.0
#: The gripper's servo (deg): where the course opens and closes it.
OPEN_DEG, CLOSED_DEG = -45.0, 45.0

# ---- masses ----

GRAVITY = 9.81  # m/s^2

#: The turret that joint 1 turns, with servo 2 in it: mass (kg) and centre (mm), forward and up from the base frame.
TURRET = (0.0984, (0.0, 68.0))
#: Links that joints 2, 3, 4 carry: mass (kg), the maker's, and centre of mass (mm), forward and up from the link's own
#: joint when all joints are at zero; read off the links' bounding boxes (the servo at the far end outweighs the rest).
UPPER_ARM = (0.1385, (13.0, 106.0))
FOREARM = (0.1327, (105.0, 0.0))
WRIST = (0.1433, (55.0, 0.0))

#: The most torque (Nm) that gravity puts on a joint: on joint 2, with the bare arm stretched out level.
HOLDING_TORQUE = 0.89

# ---- servos ----

MODEL = 1020  # XM430-W350
#: Joints 1 to 4, then the gripper.
JOINT_IDS, GRIPPER_ID = (11, 12, 13, 14), 15
ARM_IDS = (*JOINT_IDS, GRIPPER_ID)

#: Encoder ticks to a turn, and the tick at which a joint is at zero.
TICKS_PER_TURN, ZERO_TICK = 4096, 2048

STALL_TORQUE, STALL_CURRENT = 4.1, 2300.0  # Nm and mA at 12 V, for a moment only
NO_LOAD_SPEED = 46 * 2 * pi / 60  # rad/s at 12 V
#: Torque (Nm) of a motor for each mA, from the two numbers above.
TORQUE_PER_MA = STALL_TORQUE / STALL_CURRENT
SUPPLY_VOLTS = 12.0
#: A servo that pushes harder (Nm) than this for so long (s) reports an overload, and lets go.
OVERLOAD_TORQUE, OVERLOAD_S = 0.6 * STALL_TORQUE, 1.0
#: Torque (Nm) for each rad by which a joint is off its goal, at the gains from the factory: under its load it gives way
#: by the tenths of a degree that readings of the real one show.
STIFFNESS = 50.0

# ---- what an arm must be to be driven ----

OLDEST_FIRMWARE = 42  # time-based profiles came with it
WARN_VOLTS, FEWEST_VOLTS = 11.0, 10.0
WARN_DEGREES, MOST_DEGREES = 60, 70  # degrees C; the servo itself gives up at 80

#: Commands stay this far (rad) inside the joint limits.
SOFT_MARGIN = radians(2.0)
#: The fastest a joint is sent anywhere, unless the caller raises it on purpose (rad/s).
SPEED_CAP = radians(60.0)
#: The speeds (rad/s) of parking, and of the way back from outside the limits.
PARK_SPEED, SLOW = radians(30.0), radians(10.0)
#: How far (rad) a joint may stay from its goal for the arm to have arrived: the sag under the largest payload.
ARRIVED = radians(4.0)
#: Seconds without a command after which an arm that holds folds itself and switches off.
IDLE_S = 900.0
#: The most current (mA) that a joint may need to hold what it carries: a servo that does so for good warms to 57 deg C.
HOLDING_MA = 950.0
