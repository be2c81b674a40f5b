r"""Slopes multiplied out before the tangents come, where that saves work.

What a loop over tangents does is linear: a graph whose nodes are tangents and whose edges are
slopes. Where a node is left out, each way through it becomes an edge of its own,

$$ \dot y \mathrel{+}= s_{yv} \dot v, \quad \dot v = \sum_x s_{vx} \dot x
   \qquad\to\qquad \dot y \mathrel{+}= \sum_x (s_{yv} s_{vx}) \dot x, $$

which is paid once for all tangents, and what it saves is saved by each. The order is greedy, as
Markowitz's for sparse matrices: always the node that saves most. Pushing each tangent through
the operations as they stand would be simpler and takes twice the operations with four of them;
the whole Jacobian of a step, without inner nodes, is best for very many only.

A selected tangent stays one until nothing but arguments is left before it, so that what isn't
finite in a branch that isn't taken never meets a zero. From then on its slopes are selected.

Reference: A. Griewank and A. Walther, "Evaluating Derivatives", 2nd ed., SIAM 2008, chapter 9,
doi:10.1137/1.9780898717761.
"""

import heapq
from collections.abc import Iterator, Mapping, Set

from scdpr_jax.native.scalar.program import (
    Block,
    Cell,
    Constant,
    Each,
    Operation,
    Value,
    Variable,
    changed,
    statements,
)
from scdpr_jax.native.scalar.scope import ONE, ZERO, Scope, first_free

TANGENTS = 8
"""For how many tangents work is weighed up. Their number isn't compiled in; from four to twenty
it makes little difference."""

_MINUS = Constant(-1.0)
_UNITS = (ONE, _MINUS)
_LINEAR = frozenset({"add", "sub", "neg", "mul", "select", "read", "write"})
"""What differentiation leaves to be done to tangents."""

Slopes = dict[Variable, Value]
"""What a tangent depends on, and the slopes."""


def eliminated(block: Block, linear: Set[Value | Cell]) -> Block:
    """A program's body with fewer operations in its loops over tangents.

    Args:
        block: The body, with what each loop needs besides tangents done before it.
        linear: Variables and cells that depend on a tangent.

    Returns:
        A body that does the same.
    """
    program = Scope(first=first_free(block))
    wanted = _handed_on(block)

    def rest(block: Block) -> Block:
        made: list = []
        for statement in block:
            match statement:
                case Each(body) if all(own.name in _LINEAR for own in body):
                    graph = _Graph(Scope(program), body, linear)
                    graph.eliminate(kept=wanted)
                    short = Each((*graph.operations(body),))
                    made += [*_in_turn(graph.scope.statements, short), short]
                case Operation() | Each():
                    made.append(statement)
                case _:
                    made.append(changed(statement, rest))
        return tuple(made)

    return rest(block)


def _in_turn(before: list[Operation], loop: Each) -> Iterator[Operation]:
    """Those operations that a loop needs, each right before the first one that needs it."""
    places = {own.target: own for own in before}
    waiting = [own for operation in loop.body for own in reversed(operation.sources)][::-1]
    while waiting:
        own = waiting[-1]
        missing = [s for s in places[own].sources if s in places] if own in places else []
        if missing:
            waiting += missing
            continue
        waiting.pop()
        if own in places:
            yield places.pop(own)


def _handed_on(block: Block) -> set[Variable]:
    """Tangents that are made in one loop and needed in another one."""
    loops = [own for own in statements(block) if isinstance(own, Each)]
    homes = {own.target: i for i, loop in enumerate(loops) for own in loop.body}
    return {
        source
        for i, loop in enumerate(loops)
        for operation in loop.body
        for source in operation.sources
        if isinstance(source, Variable) and homes.get(source, i) != i
    }


def _cost(slopes: Mapping[Variable, Value | None]) -> int:
    """Operations of a sum: a product that is added is one, and the first term as it is none."""
    as_it_is = _UNITS if len(slopes) > 1 else (ONE,)
    return len(slopes) - any(slope in as_it_is for slope in slopes.values())


class _Graph:
    """The tangents of one loop, and the slopes between them, in the order of the loop."""

    def __init__(self, scope: Scope, body: tuple[Operation, ...], linear: Set[Value | Cell]):
        self.scope, self.linear = scope, linear
        self.before: dict[Variable, Slopes] = {}
        self.behind: dict[Variable, dict[Variable, None]] = {}
        self.masks: dict[Variable, Value] = {}
        """Where alone a tangent isn't zero, whatever it depends on."""
        self.arguments: set[Variable] = set()
        """Tangents that are always finite."""
        for operation in body:
            self._add(operation)
        self.kept = {own.sources[0] for own in body if own.name == "write"}
        for node, sources in self.before.items():
            for source in sources:
                self.behind.setdefault(source, {})[node] = None

    def _add(self, operation: Operation) -> None:
        target = operation.target
        match operation:
            case Operation(_, "read", (Cell(array),)) if array:
                self.arguments.add(target)
            case Operation(_, "add", (x, y)):
                self._put(target, (x, ONE), (y, ONE))
            case Operation(_, "sub", (x, y)):
                self._put(target, (x, ONE), (y, _MINUS))
            case Operation(_, "neg", (x,)):
                self._put(target, (x, _MINUS))
            case Operation(_, "mul", (x, y)):
                self._put(target, (x, y), (y, x))
            case Operation(_, "select", (condition, x, y)):
                self._choose(target, condition, (x, y))

    def _put(self, target: Variable, *terms: tuple[Value, Value]) -> None:
        """A tangent as a sum of others, each with its slope."""
        slopes: Slopes = {}
        for source, slope in terms:
            if source in self.linear:
                slopes[source] = self.scope.apply("add", slopes.get(source, ZERO), slope)
        self.before[target] = slopes

    def _choose(self, target: Variable, condition: Value, cases: tuple[Value, Value]) -> None:
        """One of two tangents: the sum of both, each with a mask."""
        masks = condition, self.scope.apply("not", condition)
        ways = [pair for pair in zip(cases, masks, strict=True) if pair[0] in self.linear]
        nodes = [target] if len(ways) == 1 else [self.scope.variable() for _ in ways]
        for node, (source, mask) in zip(nodes, ways, strict=True):
            self._put(node, (source, ONE))
            self.masks[node] = mask
        if nodes != [target]:
            self.before[target] = dict.fromkeys(nodes, ONE)

    def eliminate(self, *, kept: Set[Variable]) -> None:
        """Leaves nodes out as long as that saves work, but for those that are kept."""
        self.kept |= kept
        queue: list = []
        self._consider(queue, list(self.before))
        while queue:
            promised, _, node = heapq.heappop(queue)
            saved = self._saved(node)
            if saved <= 0:
                continue
            if saved < -promised:
                heapq.heappush(queue, (-saved, node.number, node))
                continue
            self._consider(queue, self._leave_out(node))

    def _consider(self, queue: list, nodes: list[Variable]) -> None:
        for node in nodes:
            self._unmask(node)
        for node in nodes:
            saved = self._saved(node)
            if saved > 0:
                heapq.heappush(queue, (-saved, node.number, node))

    def _unmask(self, node: Variable) -> None:
        """Selects the slopes of a tangent instead of itself, once that is safe."""
        if node in self.masks and self.arguments.issuperset(self.before[node]):
            mask = self.masks.pop(node)
            for source, slope in self.before[node].items():
                self.before[node][source] = self.scope.apply("select", mask, slope, ZERO)

    def _saved(self, node: Variable) -> int:
        """Operations that all tangents together are saved without a node."""
        if node not in self.before or node in self.kept or node in self.masks:
            return 0
        before, behind = self.before[node], self.behind.get(node, {})
        saved, products, sums = _cost(before), 0, 0
        for target in behind:
            slopes = self.before[target]
            rest = {own: slope for own, slope in slopes.items() if own is not node}
            through = before if slopes[node] in _UNITS else dict.fromkeys(before)
            saved += _cost(slopes) - _cost(through | rest)
            products += sum(slope not in _UNITS for slope in before.values()) * (
                slopes[node] not in _UNITS
            )
            sums += sum(own in rest for own in before)
        return TANGENTS * saved - products - sums

    def _leave_out(self, node: Variable) -> list[Variable]:
        """Makes each way through a node an edge, and names the nodes at their ends."""
        before, behind = self.before.pop(node), self.behind.pop(node, {})
        for source in before:
            del self.behind[source][node]
        for target in behind:
            slopes = self.before[target]
            second = slopes.pop(node)
            for source, first in before.items():
                through = self.scope.apply("mul", first, second)
                slopes[source] = self.scope.apply("add", slopes.get(source, ZERO), through)
                self.behind[source][target] = None
        return [own for own in (*before, *behind) if own in self.before]

    def operations(self, body: tuple[Operation, ...]) -> Iterator[Operation]:
        """The loop's operations now: what it reads, the graph, what it writes."""
        yield from (own for own in body if own.name == "read")
        for node, slopes in self.before.items():
            yield from self._sum(node, slopes)
        yield from (own for own in body if own.name == "write")

    def _sum(self, node: Variable, slopes: Slopes) -> Iterator[Operation]:
        """A tangent from others."""
        terms = [own for own in slopes.items() if own[1] != ZERO] or [(ZERO, ONE)]
        terms.sort(key=lambda term: term[1] != ONE)
        total: Value = ZERO
        for i, (source, slope) in enumerate(terms):
            last = i == len(terms) - 1 and node not in self.masks
            target = node if last else self.scope.variable()
            yield from self._term(target, total, source, slope)
            total = target
        if node in self.masks:
            yield Operation(node, "select", (self.masks[node], total, ZERO))

    def _term(
        self, target: Variable, total: Value, source: Value, slope: Value
    ) -> Iterator[Operation]:
        """A sum with one more term; a number less zero is that number."""
        match slope:
            case Constant(1.0):
                first = total == ZERO
                sources = (source, ZERO) if first else (total, source)
                yield Operation(target, "sub" if first else "add", sources)
            case Constant(-1.0):
                yield Operation(target, "sub", (total, source))
            case _ if total == ZERO:
                yield Operation(target, "mul", (slope, source))
            case _:
                product = self.scope.variable()
                yield Operation(product, "mul", (slope, source))
                yield Operation(target, "add", (total, product))
