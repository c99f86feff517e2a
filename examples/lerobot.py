"""From a dataset of LeRobot to a diagnosis: python examples/lerobot.py [DATASET [URDF]]

DATASET is the folder with `meta/info.json`, of version 2 or 3. Its features are `observation.state` [rad] and
`observation.effort` [N m]; without efforts, `action` and `observation.state` identify the position controllers instead
(docs/book/src/servos.md). The guessed mapping is written, and read by the second command: change its units where they are
degrees or percent.
"""

import sys
from pathlib import Path

import armident

HERE = Path(__file__).parent


def main(dataset=HERE / "logs" / "lerobot", robot=HERE.parent / "urdf" / "ur5.urdf"):
    print(armident.info(dataset, robot=robot, write_mapping="lerobot_mapping.toml"))
    result = armident.diagnose(robot, dataset, mapping="lerobot_mapping.toml")
    print(result)
    result.save_report("lerobot_report.html")


if __name__ == "__main__":
    main(*sys.argv[1:])
