"""Lets mypy read the types that pydrake ships.

Its stubs write an array of floats as ``ndarray[float64, ...]``, where numpy has the shape first and
then the type of the entries, and the value of a port as ``object``. Here the first becomes an array
of floats of any shape, and the second `Any`: a port's value is what its system says. A system that
is added to a builder is returned as itself, where the stubs say `System`.
"""

from __future__ import annotations

from collections.abc import Callable

from mypy.plugin import AnalyzeTypeContext, MethodContext, Plugin
from mypy.types import AnyType, Type, TypeOfAny, UnboundType

ARRAY = "numpy.ndarray"
VALUES = ("InputPort.Eval", "OutputPort.Eval", "AbstractValue.get_value")
ADDED = ("DiagramBuilder.AddSystem", "DiagramBuilder.AddNamedSystem")


def array_type(context: AnalyzeTypeContext) -> Type:
    """Return the type of an array, with the type of its entries where a stub put the shape."""
    free = AnyType(TypeOfAny.special_form)
    arguments = list(context.type.args)
    if not arguments:
        return context.api.named_type(ARRAY, [free, free])
    first = arguments[0]
    entries = first.name.rpartition(".")[2] if isinstance(first, UnboundType) else ""
    if entries.startswith(("float", "int", "uint", "bool", "object", "complex")):
        if entries.startswith("object"):
            return context.api.named_type(ARRAY, [free, free])
        dtype = context.api.named_type("numpy.dtype", [context.api.analyze_type(first)])
        return context.api.named_type(ARRAY, [free, dtype])
    found = [context.api.analyze_type(argument) for argument in arguments]
    return context.api.named_type(ARRAY, [*found, free][:2])


def any_value(context: MethodContext) -> Type:
    """Return `Any` where the stub says `object`."""
    return AnyType(TypeOfAny.special_form)


def added_system(context: MethodContext) -> Type:
    """Return the type of the system that is added, the last argument."""
    given = context.arg_types[-1]
    return given[0] if given else context.default_return_type


class PydrakePlugin(Plugin):
    """What is read otherwise in the stubs of pydrake."""

    def get_type_analyze_hook(self, fullname: str) -> Callable[[AnalyzeTypeContext], Type] | None:
        """Return the reader of array types."""
        return array_type if fullname == ARRAY else None

    def get_method_hook(self, fullname: str) -> Callable[[MethodContext], Type] | None:
        """Return the type of a port's value, or of an added system."""
        if not fullname.startswith("pydrake."):
            return None
        if fullname.endswith(ADDED):
            return added_system
        return any_value if fullname.endswith(VALUES) else None


def plugin(version: str) -> type[Plugin]:
    """Return the plugin, whatever mypy's version."""
    return PydrakePlugin
