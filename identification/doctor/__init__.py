"""The log doctor: slips in a campaign, found and named before anything is fitted."""

from identification.doctor.examine import examine as examine
from identification.doctor.findings import Finding as Finding
from identification.doctor.findings import findings_document as findings_document
from identification.doctor.findings import write_findings as write_findings
