"""What the nodes ask of the middleware beyond the quality of service that ROS can say."""

import os
from pathlib import Path

from bearing_twin.paths import share_path

PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"  # read by Fast DDS 2, which Jazzy has, when a process makes its first node
OF_THE_FOLDER = "DEFAULT_FASTRTPS_PROFILES.xml"  # read where a node starts


def repair_soon() -> None:
    """Lets publishers of this process tell ten times a second what they sent, unless the user gave profiles.

    Of a message that went astray subscribers of Fast DDS learn by that alone, every 3 s by default: by then a publisher
    of 1000 messages a second has let go of it. Raises BearingTwinError where the file of the profile is missing.
    """
    if PROFILES not in os.environ and not Path(OF_THE_FOLDER).exists():
        os.environ[PROFILES] = str(share_path("config", "fastdds.xml"))
