"""Shipped bearing scenes and variants of them: they show what chooser and companion are worth.

Each is a scene and what differs from it. Numbers were chosen with `CASES`, and fitted to no other. Those of `FURTHER`
have what no table of steppers holds. Those of `LATER` were chosen after these, and helped to find faults, as
docs/doubt.md says, and so did those of `LAST`, chosen later still; those of `HELD` were chosen before what `LAST`
showed was mended, and first run after it. So were those of `RINGS`, but what they gave was seen while it was. Those of
`AFTER` were chosen when what all these showed of balls in flight was mended, and run for the first time then; nothing
was mended by those of `CHOSEN_LAST`.
"""

CASES = {  # name: scene, what differs; those after the seventh are variants
    "settled": ("bearing_6203", ("run.duration=0.2",)),
    "6205": ("bearing_6205", ("run.duration=0.2",)),
    "fast": ("bearing_6203_fast", ("run.duration=0.1",)),
    "sticking": ("bearing_6203_sticking", ("run.duration=0.05",)),
    "lift-off": ("bearing_6203_loose", ("run.duration=0.2",)),
    "from rest": ("bearing_6203_start", ()),
    "sudden": ("bearing_6203_sudden", ("run.duration=0.05",)),
    "slippery, off centre": (
        "bearing_6203",
        ("run.duration=0.1", "contact.friction_coefficient=0.02", "drive.offset=[0,-2e-6,2e-5]"),
    ),
    "sped up": ("bearing_6203", ("run.duration=0.1", "drive.change.time=0.03", "drive.change.speed=50")),
    "lift-off, faster": ("bearing_6203_loose", ("run.duration=0.1", "drive.speed=400")),
    "lift-off, wider": (
        "bearing_6203_loose",
        ("run.duration=0.1", "geometry.radial_clearance=20e-6", "drive.offset=[2e-6,-14e-6,0]"),
    ),
    "6205, lift-off": (
        "bearing_6205",
        ("run.duration=0.1", "geometry.radial_clearance=10e-6", "drive.offset=[0,-8e-6,0]"),
    ),
    "from rest, off centre": (
        "bearing_6203_start",
        ("run.duration=0.02", "drive.speed=90", "drive.offset=[3e-6,-2e-6,8e-6]"),
    ),
    "sudden, harder": ("bearing_6203_sudden", ("run.duration=0.04", "drive.change.offset=[2e-6,-5e-6,1e-6]")),
}
VARIANTS = {
    "slow": ("bearing_6203", ("drive.speed=20",)),
    "three times faster": ("bearing_6203", ("drive.speed=550",)),
    "slippery": ("bearing_6203", ("contact.friction_coefficient=0.01",)),
    "rough": ("bearing_6203", ("contact.friction_coefficient=0.2",)),
    "creep at 3 mm/s": ("bearing_6203", ("contact.friction_regularisation=3e-3",)),
    "creep at 0.3 mm/s": ("bearing_6203", ("contact.friction_regularisation=3e-4",)),
    "hardly damped": ("bearing_6203", ("contact.relaxation_time=1e-8",)),
    "soft balls": ("bearing_6203", ("materials.ball.young_modulus=2e10",)),
    "ceramic balls": ("bearing_6203", ("materials.ball.young_modulus=3.1e11", "materials.ball.density=3200")),
    "pressed along the axis": ("bearing_6203", ("drive.offset=[0, 0, 3e-5]",)),
    "open grooves": ("bearing_6203", ("geometry.inner_conformity=0.54", "geometry.outer_conformity=0.54")),
    "six balls": ("bearing_6203", ("geometry.balls=6",)),
    "no gravity": ("bearing_6203", ("gravity=[0, 0, 0]",)),
    "off centre": ("bearing_6203", ("drive.offset=[0, -2e-6, 0]",)),
    "loose, deep": ("bearing_6203_loose", ("drive.offset=[0, -14e-6, 0]",)),
    "loose, fast": ("bearing_6203_loose", ("drive.speed=500",)),
    "loose, along the axis": ("bearing_6203_loose", ("drive.offset=[0, -9e-6, 3e-5]",)),
    "loose from rest": ("bearing_6203_loose", ("initial.motion=rest",)),
    "rest at 500 rad/s": ("bearing_6203_start", ("drive.speed=500",)),
    "rest, slippery": ("bearing_6203_start", ("contact.friction_coefficient=0.02",)),
    "small jump": ("bearing_6203", ("drive.change={time: 5e-3, offset: [0, 1e-6, 0]}",)),
    "great jump": ("bearing_6203", ("drive.change={time: 5e-3, offset: [0, 8e-6, 0]}",)),
    "quicker at once": (
        "bearing_6203",
        ("drive.change={time: 5e-3, speed: 100}", "drive.acceleration=1e6"),
    ),
    "6205 fast": ("bearing_6205", ("drive.speed=1500",)),
}
FURTHER = {
    "ring under 250 N, even cage": ("bearing_6203_rig_1000N", ("rings.inner.load=[0, -250, 0]", "drive.speed=300")),
    "ring pressed along the axis": ("bearing_6203_rig_400N", ("rings.inner.load=[0, -200, 100]", "drive.speed=120")),
    "ring, seven balls, load doubles": (
        "bearing_6203_rig_400N",
        ("geometry.balls=7", "rings.inner.change={time: 0.02, load: [0, -800, 0]}"),
    ),
    "ring runs up": (
        "bearing_6203_rig_400N",
        ("drive.acceleration=2000", "drive.change={time: 0.02, speed: 60}"),
    ),
    "ring, unbalance, fast": ("bearing_6203_unbalance", ("drive.speed=800", "rings.inner.unbalance=2e-5")),
    "ring without a cage": ("bearing_6203_rig_1000N", ("cage.kind=none", "geometry.radial_clearance=2e-6")),
    "ring, pockets": ("bearing_6203_rig_400N", ("cage.kind=pockets", "rings.inner.load=[0, -600, 0]")),
    "held ring, pockets": ("bearing_6203", ("cage.kind=pockets", "drive.offset=[0, -3e-6, 1e-5]")),
    "held ring, even cage": ("bearing_6203", ("cage.kind=even", "drive.offset=[0, -4e-6, 0]")),
    "tilted, more": ("bearing_6203_tilted", ("drive.tilt=[2e-3, 1e-3]", "drive.speed=250")),
    "springs, tighter": (
        "bearing_6205",
        ("contact.normal=linear", "contact.stiffness=3e7", "geometry.radial_clearance=-1e-5"),
    ),
    "friction over the spot": (
        "bearing_6203",
        ("contact.friction=spot", "drive.offset=[0, 0, 2e-5]", "drive.speed=90"),
    ),
    "eleven balls, loose": (
        "bearing_6205",
        ("geometry.balls=11", "geometry.radial_clearance=8e-6", "drive.offset=[3e-6, -6e-6, 0]", "drive.speed=120"),
    ),
}
LATER = {
    "6205, loose, slow": (
        "bearing_6205",
        ("geometry.radial_clearance=15e-6", "drive.offset=[0, -11e-6, 0]", "drive.speed=80"),
    ),
    "loose, slippery, faster": (
        "bearing_6203_loose",
        ("contact.friction_coefficient=0.03", "drive.speed=300", "drive.offset=[1e-6, -8e-6, 0]"),
    ),
    "ceramic balls, loose": (
        "bearing_6203_loose",
        ("materials.ball.young_modulus=3.1e11", "materials.ball.density=3200", "drive.speed=600"),
    ),
    "rest, rough, off centre": (
        "bearing_6203_start",
        ("contact.friction_coefficient=0.15", "drive.offset=[0, -3e-6, 5e-6]", "drive.speed=200"),
    ),
    "jump across": ("bearing_6203", ("drive.change={time: 0.01, offset: [3e-6, 0, 0]}", "drive.speed=220")),
    "slowed at once": ("bearing_6203", ("drive.change={time: 8e-3, speed: -100}", "drive.acceleration=1e6")),
    "loose, even cage": ("bearing_6203_loose", ("cage.kind=even", "drive.speed=250")),
    "pockets, pressed": ("bearing_6203", ("cage.kind=pockets", "drive.offset=[0, 0, 2e-5]", "drive.speed=150")),
    "ring, unbalance and thrust": (
        "bearing_6203_unbalance",
        ("rings.inner.load=[0, -150, 60]", "rings.inner.unbalance=4e-5", "drive.speed=500"),
    ),
    "ring, 500 N, no cage": (
        "bearing_6203_rig_1000N",
        ("cage.kind=none", "rings.inner.load=[0, -500, 0]", "geometry.radial_clearance=5e-6"),
    ),
    "ring, six balls, 700 N": (
        "bearing_6203_rig_400N",
        ("geometry.balls=6", "rings.inner.load=[0, -700, 0]", "drive.speed=220"),
    ),
    "ring runs down": (
        "bearing_6203_rig_1000N",
        ("drive.acceleration=3000", "drive.change={time: 0.01, speed: -80}"),
    ),
    "light ring": ("bearing_6203_rig_400N", ("rings.inner.load=[0, -80, 0]", "rings.inner.mass=0.2")),
    "ring, load turns": (
        "bearing_6203_rig_400N",
        ("rings.inner.change={time: 0.03, load: [300, 300, 0]}", "drive.speed=180"),
    ),
    "ring, hardly damped": ("bearing_6203_rig_1000N", ("contact.relaxation_time=3e-7", "drive.speed=100")),
}
LAST = {
    "6205, jump, loose": (
        "bearing_6205",
        (
            "geometry.radial_clearance=12e-6",
            "drive.offset=[0, -9e-6, 0]",
            "drive.change={time: 0.012, offset: [4e-6, 2e-6, 0]}",
        ),
    ),
    "jump down": ("bearing_6203", ("drive.change={time: 7e-3, offset: [-2e-6, -5e-6, 0]}", "drive.speed=130")),
    "jump, slippery, fast": (
        "bearing_6203",
        (
            "drive.change={time: 4e-3, offset: [0, 6e-6, 0]}",
            "contact.friction_coefficient=0.03",
            "drive.speed=350",
        ),
    ),
    "ring, load reverses": (
        "bearing_6203_rig_400N",
        ("rings.inner.change={time: 0.02, load: [0, 250, 0]}", "drive.speed=140"),
    ),
    "ring, load swings": (
        "bearing_6203_rig_1000N",
        ("rings.inner.change={time: 0.025, load: [-600, -500, 0]}", "drive.speed=200"),
    ),
    "ring, 300 N, slow": ("bearing_6203_rig_400N", ("rings.inner.load=[0, -300, 0]", "drive.speed=60")),
    "ring, clearance of 4 um": ("bearing_6203_rig_1000N", ("geometry.radial_clearance=4e-6", "drive.speed=250")),
    "ring slows": (
        "bearing_6203_rig_1000N",
        ("drive.acceleration=2000", "drive.change={time: 0.015, speed: -50}", "rings.inner.load=[0, -700, 0]"),
    ),
    "loose, seven balls": ("bearing_6203_loose", ("geometry.balls=7", "drive.speed=220")),
    "loose, thrust": ("bearing_6203_loose", ("drive.offset=[1e-6, -10e-6, 2e-5]", "drive.speed=350")),
    "rest, little friction": ("bearing_6203_start", ("contact.friction_coefficient=0.04", "drive.speed=150")),
    "even cage, held, loose": ("bearing_6203_loose", ("cage.kind=even", "drive.offset=[2e-6, -12e-6, 0]")),
    "tilted, slow": ("bearing_6203_tilted", ("drive.tilt=[1e-3, 5e-4]", "drive.speed=80")),
}
HELD = {
    "jump up, 6205": ("bearing_6205", ("drive.change={time: 6e-3, offset: [0, 4e-6, 1e-6]}", "drive.speed=260")),
    "jump, rough": (
        "bearing_6203",
        ("drive.change={time: 9e-3, offset: [-4e-6, 3e-6, 0]}", "contact.friction_coefficient=0.13", "drive.speed=90"),
    ),
    "jump along the axis": ("bearing_6203", ("drive.change={time: 5e-3, offset: [0, 0, 2e-5]}", "drive.speed=240")),
    "jump, six balls": (
        "bearing_6203",
        ("geometry.balls=6", "drive.change={time: 8e-3, offset: [5e-6, -4e-6, 0]}", "drive.speed=160"),
    ),
    "jump, ceramic": (
        "bearing_6203",
        (
            "materials.ball.young_modulus=3.1e11",
            "materials.ball.density=3200",
            "drive.change={time: 6e-3, offset: [2e-6, 5e-6, 0]}",
        ),
    ),
    "loose, jump deeper": ("bearing_6203_loose", ("drive.change={time: 0.01, offset: [0, -3e-6, 0]}",)),
    "loose, 300 rad/s": ("bearing_6203_loose", ("drive.speed=300", "drive.offset=[-2e-6, -11e-6, 0]")),
    "loose, six balls": ("bearing_6203_loose", ("geometry.balls=6", "drive.speed=140")),
    "loose, rough": ("bearing_6203_loose", ("contact.friction_coefficient=0.16", "drive.speed=200")),
    "6205, loose, 150 rad/s": (
        "bearing_6205",
        ("geometry.radial_clearance=9e-6", "drive.offset=[0, -7e-6, 4e-6]", "drive.speed=150"),
    ),
    "rest, 60 rad/s": ("bearing_6203_start", ("drive.speed=60", "drive.offset=[0, -2e-6, 6e-6]")),
    "slowed, pressed": (
        "bearing_6203",
        ("drive.change={time: 0.01, speed: -60}", "drive.acceleration=5e4", "drive.offset=[0, -1e-6, 1e-5]"),
    ),
    "creep at 1 mm/s, off centre": (
        "bearing_6203",
        ("contact.friction_regularisation=1e-3", "drive.offset=[1e-6, -3e-6, 0]"),
    ),
    "tilted, even, 400 rad/s": ("bearing_6203_tilted", ("drive.tilt=[5e-4, 15e-4]", "drive.speed=400")),
    "pockets, off centre": (
        "bearing_6203",
        ("cage.kind=pockets", "drive.offset=[2e-6, -3e-6, 1e-5]", "drive.speed=220"),
    ),
}
RINGS = {
    "ring, 600 N, 300 rad/s": ("bearing_6203_rig_400N", ("rings.inner.load=[0, -600, 0]", "drive.speed=300")),
    "ring, load halves": (
        "bearing_6203_rig_1000N",
        ("rings.inner.change={time: 0.02, load: [0, 500, 0]}", "drive.speed=170"),
    ),
    "ring, load swings over": (
        "bearing_6203_rig_400N",
        ("rings.inner.change={time: 0.025, load: [400, 200, 0]}", "drive.speed=240"),
    ),
    "ring, unbalance, 300 rad/s": ("bearing_6203_unbalance", ("drive.speed=300", "rings.inner.unbalance=8e-5")),
    "ring, nine balls, thrust": (
        "bearing_6205",
        (
            "model.dimension=free",
            "rings.inner.load=[0, -300, 80]",
            "rings.inner.mass=0.6",
            "rings.inner.inertia=[1e-4, 1e-4]",
            "cage.kind=even",
            "drive.speed=200",
        ),
    ),
    "ring, heavy": ("bearing_6203_rig_400N", ("rings.inner.mass=2.0", "drive.speed=190")),
    "ring speeds up, 800 N": (
        "bearing_6203_rig_1000N",
        ("drive.acceleration=4000", "drive.change={time: 0.01, speed: 70}", "rings.inner.load=[0, -800, 0]"),
    ),
}
AFTER = {
    "jump, seven balls": (
        "bearing_6203",
        ("geometry.balls=7", "drive.change={time: 6e-3, offset: [-3e-6, -5e-6, 2e-6]}", "drive.speed=210"),
    ),
    "6205, jump across": (
        "bearing_6205",
        ("drive.change={time: 0.011, offset: [6e-6, 1e-6, 0]}", "drive.speed=130"),
    ),
    "loose, jump up": (
        "bearing_6203_loose",
        ("drive.change={time: 0.015, offset: [2e-6, 4e-6, 0]}", "drive.speed=240"),
    ),
    "jump, stopped at once": (
        "bearing_6203",
        ("drive.change={time: 7e-3, offset: [0, -4e-6, 0], speed: -120}", "drive.acceleration=2e5"),
    ),
    "loose, wide, 110 rad/s": (
        "bearing_6203_loose",
        ("geometry.radial_clearance=18e-6", "drive.offset=[3e-6, -13e-6, 0]", "drive.speed=110"),
    ),
    "6205, loose, soft": (
        "bearing_6205",
        (
            "materials.ball.young_modulus=8e10",
            "geometry.radial_clearance=14e-6",
            "drive.offset=[-4e-6, -12e-6, 0]",
            "drive.speed=270",
        ),
    ),
    "loose, runs up": (
        "bearing_6203_loose",
        ("drive.acceleration=5000", "drive.change={time: 0.01, speed: 200}", "drive.offset=[0, -10e-6, 5e-6]"),
    ),
    "rest, seven balls": (
        "bearing_6203_start",
        ("geometry.balls=7", "drive.speed=130", "drive.offset=[1e-6, 2e-6, 0]"),
    ),
    "even cage, jump": ("bearing_6203", ("cage.kind=even", "drive.change={time: 0.01, offset: [0, 3e-6, 0]}")),
    "ring, 350 N, 260 rad/s": (
        "bearing_6203_rig_400N",
        ("rings.inner.load=[50, -350, 20]", "drive.speed=260", "geometry.radial_clearance=3e-6"),
    ),
    "ring runs up, 600 N": (
        "bearing_6203_rig_1000N",
        ("drive.acceleration=2500", "drive.change={time: 0.02, speed: 90}", "rings.inner.load=[0, -600, 0]"),
    ),
    "pockets, slow": ("bearing_6203", ("cage.kind=pockets", "drive.offset=[0, -2e-6, 1e-5]", "drive.speed=120")),
}
CHOSEN_LAST = {
    "6205, off centre": ("bearing_6205", ("drive.offset=[2e-6, -3e-6, 1e-5]", "drive.speed=350")),
    "ceramic, off centre": (
        "bearing_6203",
        (
            "materials.ball.young_modulus=3.1e11",
            "materials.ball.density=3200",
            "drive.offset=[0, -3e-6, 0]",
            "drive.speed=240",
        ),
    ),
    "loose, 320 rad/s": ("bearing_6203_loose", ("drive.offset=[2e-6, -10e-6, 0]", "drive.speed=320")),
    "jump aside": ("bearing_6203", ("drive.change={time: 8e-3, offset: [3e-6, 1e-6, 0]}", "drive.speed=160")),
    "rest, pressed": ("bearing_6203_start", ("drive.speed=300", "drive.offset=[0, 0, 2e-5]")),
    "ring, 550 N, 150 rad/s": ("bearing_6203_rig_400N", ("rings.inner.load=[0, -550, 0]", "drive.speed=150")),
    "ring, load rises": (
        "bearing_6203_rig_400N",
        ("rings.inner.load=[0, -300, 0]", "rings.inner.change={time: 0.03, load: [0, -700, 0]}"),
    ),
    "even cage, off centre": (
        "bearing_6203",
        ("cage.kind=even", "drive.offset=[0, -2.5e-6, 5e-6]", "drive.speed=200"),
    ),
    "tilted, fast": ("bearing_6203_tilted", ("drive.tilt=[5e-4, 9e-4]", "drive.speed=350")),
    "slows, off centre": (
        "bearing_6203",
        ("drive.offset=[0, -2e-6, 0]", "drive.acceleration=3000", "drive.change={time: 0.03, speed: -70}"),
    ),
}
SPANS = {  # s of those whose balls hit each other again and again, or that start from rest
    "loose from rest": 0.02,
    "eleven balls, loose": 0.05,
    "rest, little friction": 0.03,
    "rest, seven balls": 0.03,
}
UNSEEN = {
    name: (scene, (*differs, f"run.duration={SPANS.get(name, 0.1)}"))
    for name, (scene, differs) in (VARIANTS | FURTHER | LATER | LAST | HELD | RINGS | AFTER | CHOSEN_LAST).items()
}
GROUPS = {
    "Scenes known": CASES,
    "Scenes that showed what to mend": VARIANTS | FURTHER | LATER | LAST | HELD | RINGS | AFTER,
    "Chosen last": CHOSEN_LAST,
}
