import dataclasses

from short_runs import bare_run

from identification.campaign import Campaign
from identification.many.campaigns import estimate_each


def test_a_campaign_that_fails_is_a_row_with_its_reason_and_the_others_go_on():
    good = Campaign(name="good", runs=(bare_run("torque_step"),))
    blind = dataclasses.replace(bare_run("torque_step"), camera=None)
    bad = Campaign(name="bad", runs=(blind,))

    fitted = []

    def fit(campaign):
        if campaign.runs[0].camera is None:
            raise ValueError("where it started is unknown")
        fitted.append(campaign.name)

    rows = list(estimate_each([good, bad, good], fit=fit))
    assert [row.name for row in rows] == ["good", "bad", "good"]
    assert fitted == ["good", "good"]
    assert [row.failure for row in rows] == ["", "where it started is unknown", ""]
