"""What a proposal says of one column, which the doctor's findings may still change."""

import dataclasses

from identification.bring.mapping.document import ClockTable, ColumnTable


@dataclasses.dataclass(frozen=True, kw_only=True)
class Choice:
    """A line of a mapping."""

    channel: str | None = None
    """The channel, None of a clock that is a rate, or where none was found."""
    unit: str = ""
    """Its unit, empty where nothing tells it."""
    rate: str = ""
    """The rate of a clock without a channel."""
    scale: float = 1.0
    """What numbers are multiplied with."""
    sign: int = 1
    """Their sign."""
    offset: str = ""
    """What is added."""
    wraps: float | None = None
    """Where a counter overflows."""
    lost: tuple[float, ...] = ()
    """Values that mean not seen."""
    own_time: tuple[str, str] | None = None
    """Channel and unit of its own clock."""
    why: tuple[str, ...] = ()
    """Why, a reason each."""

    def because(self, reason: str, **changes: object) -> "Choice":
        """The choice changed, with a reason more.

        Args:
            reason: The reason.
            **changes: What is changed, by its field.

        Returns:
            The changed choice.
        """
        return dataclasses.replace(self, why=(*self.why, reason), **changes)

    def table(self) -> ColumnTable:
        """The choice as a mapping has it.

        Returns:
            The table.
        """
        time = None
        if self.own_time is not None:
            time = ClockTable(channel=self.own_time[0], unit=self.own_time[1])
        return ColumnTable.model_validate(
            {
                "channel": self.channel,
                "unit": self.unit or None,
                **({"rate": self.rate} if self.rate else {}),
                "scale": self.scale,
                "sign": self.sign,
                "offset": self.offset or None,
                "wraps": self.wraps,
                "lost": list(self.lost),
                "t": time,
            }
        )
