"""`bearing_twin topics`: what a scene, or every kind of scene, publishes and logs."""

from bearing_twin.command.outcome import Outcome, listed

HELP = "list the topics of a scene, or of every kind of scene"
EXAMPLES = ("bearing_twin topics bearing_6203", "bearing_twin topics")


def add_arguments(parser) -> None:
    """The arguments of the subcommand."""
    parser.add_argument("scene", nargs="?", help="name of a scene or path of a YAML file; without, every kind")
    parser.add_argument("--markdown", action="store_true", help="the text of docs/topics.md")


def run(arguments) -> Outcome:
    """The table, as text, JSON or Markdown; raises SceneError."""
    from bearing_twin.errors import BearingTwinError
    from bearing_twin.kinds import KINDS
    from bearing_twin.log import topic_table
    from bearing_twin.run.scene import load_scene

    if arguments.markdown:
        if arguments.scene:
            raise BearingTwinError("--markdown writes the table of every kind; leave out the scene")
        from bearing_twin.command.terminal import show_text

        text = topic_table.markdown()
        return Outcome({"markdown": text}, [], lambda: show_text(text.rstrip("\n")))
    if arguments.scene:
        rows = [row._asdict() for row in topic_table.scene_rows(load_scene(arguments.scene))]
        return listed("topics", topic_table.TopicRow._fields, rows)
    rows = [{"kind": kind, **row._asdict()} for kind in KINDS for row in topic_table.kind_rows(kind)]
    return listed("topics", ("kind", *topic_table.TopicRow._fields), rows)
