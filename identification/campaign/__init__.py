"""Logged runs, format 1: read, check and write."""

from identification.campaign.check import Check as Check
from identification.campaign.check import RunSummary as RunSummary
from identification.campaign.check import check_campaign as check_campaign
from identification.campaign.faults import CampaignError as CampaignError
from identification.campaign.faults import Fault as Fault
from identification.campaign.notes.note import Note as Note
from identification.campaign.read import read_campaign as read_campaign
from identification.campaign.types import KINDS as KINDS
from identification.campaign.types import AccelerometerStream as AccelerometerStream
from identification.campaign.types import CameraStream as CameraStream
from identification.campaign.types import Campaign as Campaign
from identification.campaign.types import DriveStream as DriveStream
from identification.campaign.types import Initial as Initial
from identification.campaign.types import Knock as Knock
from identification.campaign.types import Run as Run
from identification.campaign.types import Sensors as Sensors
from identification.campaign.write import write_campaign as write_campaign
