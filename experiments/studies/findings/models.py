"""What the usual model lacks, and which quantities the logs can't tell apart, in words."""

from experiments.page.number_text import plain
from identification.judge.identifiability import Identifiability
from identification.result.estimate import Estimate


def model_sentences(estimate: Estimate) -> tuple[str, ...]:
    """What the usual model lacks, in words.

    Args:
        estimate: The estimate.

    Returns:
        A sentence, or none where the usual model is enough.
    """
    if not estimate.models:
        return ()
    usual, best = estimate.models[0], estimate.models[estimate.choice]
    by = (
        ""
        if best.path_error is None
        else (
            f" It predicts the end-effector's path in the held-out runs to "
            f"{plain(1e3 * best.path_error, 3)} mm rms, the usual one to "
            f"{plain(1e3 * usual.path_error, 3)} mm."
        )
    )
    if not best.added:
        return (
            f"Of {len(estimate.models)} models none is better than the usual one, though it "
            f"leaves more than noise: what it lacks isn't among what was tried.{by}",
        )
    return (f"The usual model lacks {'; '.join(best.added)}.{by}",)


def combination_sentences(identifiable: Identifiability) -> tuple[str, ...]:
    """What these logs tell, and what they can't, in words.

    Args:
        identifiable: What the logs can tell.

    Returns:
        A sentence on each combination that they don't tell; on the worst one otherwise.
    """
    untold = identifiable.undetermined()
    if not untold:
        worst = identifiable.combinations[-1]
        return (
            f"These logs determine all {len(identifiable.names)} quantities; the least certain "
            f"is {worst.text()}, to {plain(1e2 * worst.sigma, 2)} % by the noise alone.",
        )
    return tuple(
        f"These logs can't tell {combination.text()}: "
        + (
            "nothing that was measured changes with it."
            if combination.sigma == float("inf")
            else f"its standard error is {plain(1e2 * combination.sigma, 2)} % by the noise "
            "alone."
        )
        for combination in untold
    )
