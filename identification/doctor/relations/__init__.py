"""What sensors say of each other, and of the rig."""

from identification.doctor.relations.examination import Examination as Examination
from identification.doctor.relations.examination import examination as examination
from identification.doctor.relations.examination import may_help as may_help
from identification.doctor.relations.relation import Relation as Relation
from identification.doctor.relations.relation import severity as severity
