"""Mechanisms: parts that move against each other by joints."""

from feeler.mechanism.answers import MechanismClashes as MechanismClashes
from feeler.mechanism.answers import MechanismClearance as MechanismClearance
from feeler.mechanism.answers import MechanismContact as MechanismContact
from feeler.mechanism.answers import MechanismSeat as MechanismSeat
from feeler.mechanism.answers import Range as Range
from feeler.mechanism.coupling import JointCoupling as JointCoupling
from feeler.mechanism.joint import Joint as Joint
from feeler.mechanism.joint import JointKind as JointKind
from feeler.mechanism.mechanism import Mechanism as Mechanism
from feeler.mechanism.tracks import Tracks as Tracks
from feeler.mechanism.tracks import load_tracks as load_tracks
