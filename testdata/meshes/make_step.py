"""Write `assembly.step`: a small STEP assembly of our own, for the loader's tests.

    press (assembly)
      base          a box of 40 x 20 x 10 mm
      pins          (assembly, placed by an occurrence without a name: converters call it by its number)
        pin         a cylinder, radius 3 mm, height 12 mm, at x = 10 mm
        pin         the same cylinder, at x = 30 mm

Run: python testdata/meshes/make_step.py
"""

from __future__ import annotations

from pathlib import Path

HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('feeler test assembly'),'2;1');
FILE_NAME('assembly.step','2024-01-01T00:00:00',(''),(''),'feeler','feeler','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
"""
TAIL = "ENDSEC;\nEND-ISO-10303-21;\n"

Point = tuple[float, float, float]


class Step:
    """Numbers entities and keeps their text."""

    def __init__(self) -> None:
        """Write what every file has once: contexts and units."""
        self.lines: list[str] = []
        self.application = self.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')")
        self.add(
            f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{self.application})"
        )
        self.product_context = self.add(f"PRODUCT_CONTEXT('',{self.application},'mechanical')")
        self.definition_context = self.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{self.application},'design')")
        length = self.add("( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )")
        angle = self.add("( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) )")
        solid_angle = self.add("( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() )")
        close = self.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),{length},'distance_accuracy_value','')")
        self.context = self.add(
            f"( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({close})) "
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle})) REPRESENTATION_CONTEXT('','3D') )"
        )

    def add(self, entity: str) -> str:
        """Add an entity; return its reference."""
        self.lines.append(f"#{len(self.lines) + 1} = {entity};")
        return f"#{len(self.lines)}"

    def point(self, p: Point) -> str:
        """Add a point."""
        return self.add("CARTESIAN_POINT('',({}))".format(",".join(f"{v:.6f}" for v in p)))

    def direction(self, d: Point) -> str:
        """Add a direction."""
        return self.add("DIRECTION('',({}))".format(",".join(f"{v:.6f}" for v in d)))

    def placement(self, origin: Point, axis: Point = (0, 0, 1), across: Point = (1, 0, 0)) -> str:
        """Add a coordinate system."""
        parts = f"{self.point(origin)},{self.direction(axis)},{self.direction(across)}"
        return self.add(f"AXIS2_PLACEMENT_3D('',{parts})")

    def vertex(self, p: Point) -> str:
        """Add a vertex."""
        return self.add(f"VERTEX_POINT('',{self.point(p)})")

    def line_edge(self, a: str, b: str, start: Point, end: Point) -> str:
        """Add a straight edge between two vertices."""
        way = tuple(e - s for s, e in zip(start, end, strict=True))
        length = sum(v * v for v in way) ** 0.5
        vector = self.add(f"VECTOR('',{self.direction((way[0] / length, way[1] / length, way[2] / length))},1.)")
        line = self.add(f"LINE('',{self.point(start)},{vector})")
        return self.add(f"EDGE_CURVE('',{a},{b},{line},.T.)")

    def face(self, edges: list[tuple[str, bool]], surface: str) -> str:
        """Add a face bounded by edges, each with its sense."""
        oriented = [self.add(f"ORIENTED_EDGE('',*,*,{edge},{'.T.' if forward else '.F.'})") for edge, forward in edges]
        loop = self.add(f"EDGE_LOOP('',({','.join(oriented)}))")
        bound = self.add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        return self.add(f"ADVANCED_FACE('',({bound}),{surface},.T.)")

    def solid(self, faces: list[str]) -> str:
        """Add a solid with a placement; return its shape representation."""
        shell = self.add(f"CLOSED_SHELL('',({','.join(faces)}))")
        brep = self.add(f"MANIFOLD_SOLID_BREP('',{shell})")
        return self.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({self.placement((0, 0, 0))},{brep}),{self.context})")

    def box(self, x: float, y: float, z: float) -> str:
        """Add a box from the origin."""
        corners: list[Point] = [(x * (i & 1), y * (i >> 1 & 1), z * (i >> 2 & 1)) for i in range(8)]
        vertices = [self.vertex(c) for c in corners]
        edges: dict[tuple[int, int], str] = {}
        faces = []
        for loop, normal in (
            ((0, 2, 3, 1), (0, 0, -1)), ((4, 5, 7, 6), (0, 0, 1)), ((0, 1, 5, 4), (0, -1, 0)),
            ((2, 6, 7, 3), (0, 1, 0)), ((0, 4, 6, 2), (-1, 0, 0)), ((1, 3, 7, 5), (1, 0, 0)),
        ):  # fmt: skip
            around = []
            for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
                key = (min(a, b), max(a, b))
                if key not in edges:
                    edges[key] = self.line_edge(vertices[key[0]], vertices[key[1]], corners[key[0]], corners[key[1]])
                around.append((edges[key], a < b))
            across = (0.0, 1.0, 0.0) if normal[0] else (1.0, 0.0, 0.0)
            plane = self.add(f"PLANE('',{self.placement(corners[loop[0]], normal, across)})")
            faces.append(self.face(around, plane))
        return self.solid(faces)

    def cylinder(self, radius: float, height: float) -> str:
        """Add a cylinder on the origin, along z."""
        low, high = self.vertex((radius, 0, 0)), self.vertex((radius, 0, height))
        rings = []
        for vertex, z in ((low, 0.0), (high, height)):
            circle = self.add(f"CIRCLE('',{self.placement((0, 0, z))},{radius:.6f})")
            rings.append(self.add(f"EDGE_CURVE('',{vertex},{vertex},{circle},.T.)"))
        seam = self.line_edge(low, high, (radius, 0, 0), (radius, 0, height))
        side = self.add(f"CYLINDRICAL_SURFACE('',{self.placement((0, 0, 0))},{radius:.6f})")
        bottom = self.add(f"PLANE('',{self.placement((0, 0, 0), (0, 0, -1))})")
        top = self.add(f"PLANE('',{self.placement((0, 0, height))})")
        return self.solid(
            [
                self.face([(rings[0], True), (seam, True), (rings[1], False), (seam, False)], side),
                self.face([(rings[0], False)], bottom),
                self.face([(rings[1], True)], top),
            ]
        )

    def product(self, name: str, shape: str) -> str:
        """Add a product with that shape; return its definition."""
        product = self.add(f"PRODUCT('{name}','{name}','',({self.product_context}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        definition = self.add(f"PRODUCT_DEFINITION('design','',{formation},{self.definition_context})")
        definition_shape = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        self.add(f"SHAPE_DEFINITION_REPRESENTATION({definition_shape},{shape})")
        return definition

    def assembly(self, name: str, children: list[tuple[str, str, str, Point]]) -> tuple[str, str]:
        """Add an assembly of (definition, shape, occurrence name, origin); return its definition and shape."""
        own = self.placement((0, 0, 0))
        places = [self.placement(origin) for *_, origin in children]
        shape = self.add(f"SHAPE_REPRESENTATION('',({','.join([own, *places])}),{self.context})")
        definition = self.product(name, shape)
        for number, ((child, child_shape, occurrence, _), place) in enumerate(
            zip(children, places, strict=True), start=1
        ):
            move = self.add(f"ITEM_DEFINED_TRANSFORMATION('','',{own},{place})")
            relation = self.add(
                f"( REPRESENTATION_RELATIONSHIP('','',{child_shape},{shape}) "
                f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({move}) SHAPE_REPRESENTATION_RELATIONSHIP() )"
            )
            usage = self.add(
                f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{len(self.lines)}{number}','{occurrence}','',{definition},{child},$)"
            )
            usage_shape = self.add(f"PRODUCT_DEFINITION_SHAPE('Placement','',{usage})")
            self.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{usage_shape})")
        return definition, shape


def main() -> None:
    """Write the file beside this script."""
    step = Step()
    base_shape = step.box(40, 20, 10)
    base = step.product("base", base_shape)
    pin_shape = step.cylinder(3, 12)
    pin = step.product("pin", pin_shape)
    pins, pins_shape = step.assembly(
        "pins", [(pin, pin_shape, "pin", (10, 10, 10)), (pin, pin_shape, "pin", (30, 10, 10))]
    )
    step.assembly("press", [(base, base_shape, "base", (0, 0, 0)), (pins, pins_shape, "", (0, 0, 0))])
    text = HEAD + "\n".join(step.lines) + "\n" + TAIL
    Path(__file__).with_name("assembly.step").write_text(text, encoding="ascii", newline="\n")


if __name__ == "__main__":
    main()
