"""ssik (Python and C++): analytic inverse kinematics of arms with six and seven turning joints."""

from tests.bench.peers import six_joints

WORK = six_joints.work("ssik")
