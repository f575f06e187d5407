"""A Mitsuba BSDF whose value is a random expression of reciprocal inputs: the kind of material that brood breeds."""

import drjit
import mitsuba

from reflecting_bsdf import Reflecting


class Expression(Reflecting):
    """f = g^2, g three values of a straight-line program over sums and products of the directions."""

    def __init__(self, properties, program=()):
        super().__init__(properties)
        self.program = program

    @classmethod
    def random(cls, draw, operations):
        """A program of that many scalar operations: mostly sums and products, a few sines and powers of two."""
        program = []
        for index in range(operations):
            operation = draw.choice(["add", "sub", "mul", "sin", "ex2"], p=[0.27, 0.2, 0.41, 0.07, 0.05])
            available = 5 + index
            # Mostly the latest values, or nearly all of the program would be dead.
            first = available - 1 - int(draw.integers(0, min(6, available)))
            second = available - 1 - int(draw.integers(0, available))
            program.append((operation, first, second, float(draw.normal())))
        return cls(mitsuba.Properties(), program)

    def g(self, wi, wo):
        p1, p2 = wo.z + wi.z, wo.z - wi.z
        p3 = wo.x * wi.x + wo.y * wi.y
        p4 = wo.y * wi.x - wo.x * wi.y
        values = [p1, p3, p2 * p2 - p4 * p4, 2.0 * p2 * p4, mitsuba.Float(1.0)]
        for operation, first, second, constant in self.program:
            a, b = values[first], values[second]
            values.append({
                "add": lambda: a + b * constant,
                "sub": lambda: a * constant - b,
                "mul": lambda: a * b,
                "sin": lambda: drjit.sin(a * constant),
                "ex2": lambda: drjit.exp2(drjit.clip(a, -24.0, 16.0)),
            }[operation]())
        return [drjit.clip(value, -65504.0, 65504.0) for value in values[-3:]]

    def reflected(self, light, eye):
        red, green, blue = self.g(eye, light)
        return mitsuba.Color3f(red * red, green * green, blue * blue) * light.z

    def to_string(self):
        return f"Expression[{len(self.program)} operations]"


mitsuba.register_bsdf("expression", lambda properties: Expression(properties))
