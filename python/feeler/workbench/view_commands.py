"""The page's commands as methods.

Written by tools/view_commands.py from document/commands.py: change it there.
"""

from __future__ import annotations

from typing import Any

from feeler.parts import PartsLike
from feeler.poses import PoseLike
from feeler.workbench.document.arguments import (
    IndicesLike,
    VectorLike,
    VectorsLike,
    plain_numbers,
    plain_parts,
    plain_pose,
)
from feeler.workbench.document.protocol import (
    Camera,
    CardQuestion,
    CommandAnswer,
    FindingStatus,
    GivenWay,
    Material,
    MeasureType,
    Mode,
    Pose,
    RequirementResult,
    TaskEditKind,
    Unit,
)
from feeler.workbench.session.session import Session


class ViewCommands:
    """The commands of the page; see `View`. Each raises `WorkbenchError` for arguments that cannot be."""

    session: Session

    def command(self, name: str, /, **args: object) -> CommandAnswer:
        """Runs a command of the page by its name, such as `view.command("hide", parts="*screw*")`.

        The answer has the `id` of what was added, the `pose` of the hand, `undo_depth` and `redo_depth`. Raises
        `WorkbenchError`.
        """
        return self.session.command(name, args)

    def _command(self, name: str, /, **args: object) -> CommandAnswer:
        """Without the arguments that are not given."""
        return self.command(name, **{key: value for key, value in args.items() if value is not None})

    def hide(self, parts: PartsLike) -> CommandAnswer:
        """Hides parts; they still collide."""
        return self.command("hide", parts=plain_parts(parts))

    def show(self, parts: PartsLike) -> CommandAnswer:
        """Shows hidden parts again."""
        return self.command("show", parts=plain_parts(parts))

    def show_all(self) -> CommandAnswer:
        """Shows all parts, and none as a ghost."""
        return self.command("show_all")

    def hide_all(self) -> CommandAnswer:
        """Hides all parts."""
        return self.command("hide_all")

    def isolate(self, parts: PartsLike) -> CommandAnswer:
        """Shows these parts alone; the same call again restores what was hidden before."""
        return self.command("isolate", parts=plain_parts(parts))

    def ghost(self, parts: PartsLike, is_on: bool) -> CommandAnswer:
        """Draws parts see-through, or solid again."""
        return self.command("ghost", parts=plain_parts(parts), is_on=is_on)

    def single_out(self, parts: PartsLike) -> CommandAnswer:
        """Draws these parts solid and all others see-through."""
        return self.command("single_out", parts=plain_parts(parts))

    def explode(self, share: float) -> CommandAnswer:
        """Draws the parts apart by a share, 0 to 1."""
        return self.command("explode", share=share)

    def section_add(self, normal: VectorLike, offset: float) -> CommandAnswer:
        """Adds a section plane; `offset` is its distance from the origin along `normal`, metres."""
        return self.command("section_add", normal=plain_numbers(normal), offset=offset)

    def section_move(self, id: int, normal: VectorLike, offset: float) -> CommandAnswer:
        """Moves a section plane."""
        return self.command("section_move", id=id, normal=plain_numbers(normal), offset=offset)

    def section_switch(self, id: int, is_on: bool) -> CommandAnswer:
        """Switches a section plane on or off."""
        return self.command("section_switch", id=id, is_on=is_on)

    def section_remove(self, id: int) -> CommandAnswer:
        """Removes a section plane."""
        return self.command("section_remove", id=id)

    def section_box(self, lower: VectorLike, upper: VectorLike) -> CommandAnswer:
        """Cuts everything outside a box along the world axes away; replaces the box that was there. Metres."""
        return self.command("section_box", lower=plain_numbers(lower), upper=plain_numbers(upper))

    def section_box_switch(self, is_on: bool) -> CommandAnswer:
        """Switches the section box on or off."""
        return self.command("section_box_switch", is_on=is_on)

    def section_box_remove(self) -> CommandAnswer:
        """Removes the section box."""
        return self.command("section_box_remove")

    def set_unit(self, unit: Unit) -> CommandAnswer:
        """Sets the unit in which lengths are shown."""
        return self.command("set_unit", unit=unit)

    def set_material(self, material: Material | None) -> CommandAnswer:
        """Sets the material that contact sounds like; None: steel."""
        return self.command("set_material", material=material)

    def set_mode(self, mode: Mode) -> CommandAnswer:
        """Sets what contact does to the tool: stop, glide or pass."""
        return self.command("set_mode", mode=mode)

    def place(self, pose: Pose | PoseLike) -> CommandAnswer:
        """Moves the tool to a pose, as far as contact lets it: 16 numbers of world_from_tool, row by row, metres."""
        return self.command("place", pose=plain_pose(pose))

    def grip(self, parts: PartsLike) -> CommandAnswer:
        """Grips parts: they leave the scene and move with the hand, together with those that it holds already."""
        return self.command("grip", parts=plain_parts(parts))

    def release(self) -> CommandAnswer:
        """Releases the gripped parts where they are; if they moved, this adds a step to the sequence."""
        return self.command("release")

    def put_back(self, parts: PartsLike) -> CommandAnswer:
        """Puts parts back into their places."""
        return self.command("put_back", parts=plain_parts(parts))

    def take_tool(self, name: str | None) -> CommandAnswer:
        """Takes another tool, or none; where it would collide, it starts beside the mock-up."""
        return self.command("take_tool", name=name)

    def measure_add(
        self,
        type: MeasureType,
        points: VectorsLike | None = None,
        parts: PartsLike | None = None,
        triangles: IndicesLike | None = None,
        name: str | None = None,
    ) -> CommandAnswer:
        """Adds a measure.

        `type`: "point": the distance of two `points`; "edge": the length between two `points`; "angle": of three
        `points`, the corner in the middle, or of the planes of two `triangles` (indices into `mockup.faces`); "parts":
        the least distance of two `parts`. Points are world, metres; angles are kept in radians.
        """
        return self._command(
            "measure_add",
            type=type,
            points=plain_numbers(points),
            parts=plain_parts(parts),
            triangles=plain_numbers(triangles),
            name=name,
        )

    def measure_edit(
        self,
        id: int,
        type: MeasureType | None = None,
        points: VectorsLike | None = None,
        parts: PartsLike | None = None,
        triangles: IndicesLike | None = None,
        name: str | None = None,
    ) -> CommandAnswer:
        """Renames the measure `id`, or measures something else, as `measure_add` does."""
        return self._command(
            "measure_edit",
            id=id,
            type=type,
            points=plain_numbers(points),
            parts=plain_parts(parts),
            triangles=plain_numbers(triangles),
            name=name,
        )

    def measure_remove(self, id: int) -> CommandAnswer:
        """Removes a measure."""
        return self.command("measure_remove", id=id)

    def viewpoint_add(self, camera: Camera, name: str | None = None) -> CommandAnswer:
        """Saves a camera, and the sections as they are.

        `camera`: a dict of `position` and `target`, world, metres, `up`, a direction, `fov_rad`, the whole vertical
        angle, and if wanted `is_parallel`.
        """
        return self._command("viewpoint_add", camera=camera, name=name)

    def viewpoint_show(self, id: int) -> CommandAnswer:
        """Restores the sections that a viewpoint was saved with; the camera belongs to the page."""
        return self.command("viewpoint_show", id=id)

    def viewpoint_remove(self, id: int) -> CommandAnswer:
        """Removes a saved camera."""
        return self.command("viewpoint_remove", id=id)

    def sequence_rename(self, id: int, name: str) -> CommandAnswer:
        """Renames a step of the sequence."""
        return self.command("sequence_rename", id=id, name=name)

    def sequence_move(self, id: int, index: int) -> CommandAnswer:
        """Moves a step of the sequence to another place in the order."""
        return self.command("sequence_move", id=id, index=index)

    def sequence_remove(self, id: int) -> CommandAnswer:
        """Removes a step of the sequence; its parts stay where they are."""
        return self.command("sequence_remove", id=id)

    def sequence_replay(self, id: int) -> CommandAnswer:
        """Replays a step of the sequence: grips its parts where they were and moves them along its path."""
        return self.command("sequence_replay", id=id)

    def findings_open(self, findings: Any) -> CommandAnswer:
        """Opens the findings of a clash check, as `feeler clash --json` writes them."""
        return self.command("findings_open", findings=findings)

    def findings_take(self, key: str, saved: Any | None = None) -> CommandAnswer:
        """Opens the findings that a job found. `saved`: these findings, for a record that is replayed."""
        return self._command("findings_take", key=key, saved=saved)

    def findings_close(self) -> CommandAnswer:
        """Closes the findings."""
        return self.command("findings_close")

    def finding_status(self, id: str, status: FindingStatus) -> CommandAnswer:
        """Sets the status of a finding."""
        return self.command("finding_status", id=id, status=status)

    def finding_mark(
        self,
        version: str,
        rows: IndicesLike,
        status: FindingStatus | None = None,
        note: str | None = None,
        group: int | None = None,
    ) -> CommandAnswer:
        """Sets the status, the note or the own group (its id; 0: none) of findings.

        `version`: that of the findings that are open; the command fails for another. `rows`: indices into their rows.
        """
        return self._command(
            "finding_mark", version=version, rows=plain_numbers(rows), status=status, note=note, group=group
        )

    def finding_filter(self, is_touching_hidden: bool) -> CommandAnswer:
        """Hides or shows findings that only touch."""
        return self.command("finding_filter", is_touching_hidden=is_touching_hidden)

    def finding_group_add(self, version: str, rows: IndicesLike, name: str) -> CommandAnswer:
        """Makes a group by hand, of rows of the findings of a version."""
        return self.command("finding_group_add", version=version, rows=plain_numbers(rows), name=name)

    def finding_group_rename(self, id: int, name: str) -> CommandAnswer:
        """Renames a group that was made by hand."""
        return self.command("finding_group_rename", id=id, name=name)

    def finding_group_remove(self, id: int) -> CommandAnswer:
        """Removes a group that was made by hand; its findings go back to where they were."""
        return self.command("finding_group_remove", id=id)

    def finding_ignore(self, name: str, a: str, b: str) -> CommandAnswer:
        """Adds an exclusion to the rules, for pairs of parts by two patterns, and hides the findings that it names."""
        return self.command("finding_ignore", name=name, a=a, b=b)

    def requirement_add(self, name: str, a: str, b: str, gap: float) -> CommandAnswer:
        """Adds a clearance that must hold: parts of pattern `a` at least `gap` metres away from those of `b`."""
        return self.command("requirement_add", name=name, a=a, b=b, gap=gap)

    def requirement_edit(
        self, id: int, name: str | None = None, a: str | None = None, b: str | None = None, gap: float | None = None
    ) -> CommandAnswer:
        """Changes the requirement `id`; it has to be checked again. `gap`: metres."""
        return self._command("requirement_edit", id=id, name=name, a=a, b=b, gap=gap)

    def requirement_remove(self, id: int) -> CommandAnswer:
        """Removes a requirement."""
        return self.command("requirement_remove", id=id)

    def requirements_checked(self, results: list[RequirementResult]) -> CommandAnswer:
        """Takes the verdicts of the job "verify"; requirements that are gone are left out."""
        return self.command("requirements_checked", results=results)

    def clash_settings(
        self, clearance: float | None = None, contact: float | str | None = None, rules: str | None = None
    ) -> CommandAnswer:
        """Sets how the next clash check is made.

        `clearance`, `contact`: metres, as of `feeler.clash`; `contact` may be "chord". `rules`: TOML, as of `feeler
        clash --rules`; empty for none.
        """
        return self._command("clash_settings", clearance=clearance, contact=contact, rules=rules)

    def accept_revision(self) -> CommandAnswer:
        """Accepts the present revision of the mock-up: the project's answers are about its parts from now on."""
        return self.command("accept_revision")

    def ask(
        self,
        question: CardQuestion,
        parts: PartsLike | None = None,
        without: PartsLike | None = None,
        tool: str | None = None,
        tools: list[str] | None = None,
        catalogue: bool | None = None,
        grip: str | None = None,
        swing_deg: float | None = None,
        clearance: float | None = None,
        seconds: float | None = None,
        people: int | None = None,
    ) -> CommandAnswer:
        """Asks about parts: do they come out, what has to go first, is a fastener reached, what room do they need.

        `without`: parts that are taken for gone. `tool`, `tools`: names of opened tools. Of `tools`, the answer has the
        one that swings farthest; of a task, an empty list leaves their reach unchecked. `catalogue`: take the first
        tool of the catalogue that reaches. `grip`: as of `feeler.access`. `swing_deg`: the least swing of a tool that
        counts, degrees. `clearance`: metres to keep. `people`: how many do the task. `seconds`: the time limit of the
        answer.
        """
        return self._command(
            "ask",
            question=question,
            parts=plain_parts(parts),
            without=plain_parts(without),
            tool=tool,
            tools=tools,
            catalogue=catalogue,
            grip=grip,
            swing_deg=swing_deg,
            clearance=clearance,
            seconds=seconds,
            people=people,
        )

    def card_again(self, id: int) -> CommandAnswer:
        """Asks the question of a card again, of the mock-up as it is now."""
        return self.command("card_again", id=id)

    def card_cancel(self, id: int) -> CommandAnswer:
        """Gives up a question that is not answered yet."""
        return self.command("card_cancel", id=id)

    def card_remove(self, id: int) -> CommandAnswer:
        """Removes a card, with its answer, and the guide along its way."""
        return self.command("card_remove", id=id)

    def task_edit(
        self,
        id: int,
        edit: TaskEditKind,
        parts: PartsLike,
        seconds: float | None = None,
        later: PartsLike | None = None,
    ) -> CommandAnswer:
        """Edits the task of a card, which is planned again.

        "off", "on": the parts are off already, or not. "time": their step takes `seconds`; without, as counted.
        "before", "free": the parts go before those of `later`, or need not.
        """
        return self._command(
            "task_edit", id=id, edit=edit, parts=plain_parts(parts), seconds=seconds, later=plain_parts(later)
        )

    def task_times(self, toml: str, name: str | None = None) -> CommandAnswer:
        """Takes a table of times (TOML, as of `feeler task --times`) for all tasks, which are planned again.

        An empty text takes the examples again.
        """
        return self._command("task_times", toml=toml, name=name)

    def task_catalogue(self, toml: str, name: str | None = None) -> CommandAnswer:
        """Takes a catalogue of tools (TOML, as of `feeler access --write-catalogue`) for tasks that choose from one.

        They are planned again. An empty text takes the built-in one again.
        """
        return self._command("task_catalogue", toml=toml, name=name)

    def way_take(
        self, id: int | None = None, steps: int | None = None, ways: list[GivenWay] | None = None
    ) -> CommandAnswer:
        """Takes parts out along the ways of a card, and adds them to the sequence.

        `steps`: how many of its ways that were not taken yet, all by default. `ways`: these instead of the card's, as a
        record has them.
        """
        return self._command("way_take", id=id, steps=steps, ways=ways)

    def way_check(self, id: int) -> CommandAnswer:
        """Asks whether the way of a line of the sequence holds: at every pose, and between them."""
        return self.command("way_check", id=id)

    def way_shorten(self, id: int) -> CommandAnswer:
        """Asks for a shorter way of a line of the sequence, of straight legs, with the same begin and end."""
        return self.command("way_shorten", id=id)

    def way_keep(
        self,
        id: int | None = None,
        is_added: bool | None = None,
        line: int | None = None,
        ways: list[GivenWay] | None = None,
    ) -> CommandAnswer:
        """Puts the shorter way of a card into the sequence: in place of the line's, or after it as another line.

        `ways`, of `line`: instead of the card's, as a record has them.
        """
        return self._command("way_keep", id=id, is_added=is_added, line=line, ways=ways)

    def guide(self, card: int | None = None, step: int | None = None, line: int | None = None) -> CommandAnswer:
        """Lets a way guide the hand: step `step` of a card's ways, or the way of a line of the sequence.

        The hand holds its parts. If they are nearer to its end than to its begin, it guides back. It ends by itself
        there, or when the hand lets go of them. Up to 0.1 of the size of what is in the hand (2 to 50 mm) off the way,
        a wish is drawn onto it, and beyond 0.4 (10 to 200 mm) not at all; typed poses are not drawn. A device feels at
        most 1.5 N.
        """
        return self._command("guide", card=card, step=step, line=line)

    def guide_end(self) -> CommandAnswer:
        """Ends the guidance of the hand."""
        return self.command("guide_end")

    def seat(self, pose: Pose | PoseLike) -> CommandAnswer:
        """Puts the tool at a pose at once, without a motion that contact could stop, as into a seat that was found."""
        return self.command("seat", pose=plain_pose(pose))

    def mechanism_open(self, name: str, text: str, is_start: bool | None = None) -> CommandAnswer:
        """Opens a mechanism: the text of a TOML file, and its name. Links of the one before go back to where they are
        modelled. `is_start`: it was there from the start, and is no step of undo."""
        return self._command("mechanism_open", name=name, text=text, is_start=is_start)

    def mechanism_close(self) -> CommandAnswer:
        """Closes the mechanism: its links go back to where they are modelled. Lines of the sequence stay."""
        return self.command("mechanism_close")

    def joint_move(self, name: str, value: float) -> CommandAnswer:
        """Moves a joint to a value, radians or metres, as far as contact lets it; joints that follow it follow."""
        return self.command("joint_move", name=name, value=value)

    def joint_take(self, name: str) -> CommandAnswer:
        """Takes the parts of a joint in the hand, on the joint: they move along it alone. The tool is put away."""
        return self.command("joint_take", name=name)

    def joint_step(self) -> CommandAnswer:
        """Keeps the position as lines of the sequence: one for each joint that stands elsewhere than after the lines
        before. In the order in which they were moved."""
        return self.command("joint_step")

    def joint_step_go(self, id: int) -> CommandAnswer:
        """Puts the joints where a line of the sequence leaves them, without a motion that contact could stop."""
        return self.command("joint_step_go", id=id)

    def undo(self) -> CommandAnswer:
        """Undoes the last command."""
        return self.command("undo")

    def redo(self) -> CommandAnswer:
        """Does again what was undone."""
        return self.command("redo")
