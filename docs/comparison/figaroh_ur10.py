"""The UR10 identified with FIGAROH: figaroh_ur10.py URDF TRAIN.csv HOLDOUT.csv PREDICTED.csv ols|wls"""

import csv
import pathlib
import sys

import numpy as np
from figaroh.identification.base_identification import BaseIdentification
from figaroh.tools.load_robot import load_robot
from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced

urdf, train, holdout, predicted, method = sys.argv[1:]
config = str(pathlib.Path(__file__).with_name("figaroh_ur10.yaml"))


class UR10(BaseIdentification):
    def load_trajectory_data(self, data_source=None):
        table = np.genfromtxt(data_source or train, delimiter=",", names=True, deletechars="")
        names = self.identif_config["active_joints"]
        of = lambda what: np.column_stack([table[f"{n}/{what}"] for n in names])
        return {
            "timestamps": table["t"],
            "positions": of("position"),
            "velocities": None,
            "accelerations": None,
            "torques": of("effort"),
        }

    def process_torque_data(self, **kwargs):
        filters = self.identif_config["filter_config"]["filter_params"]
        self.processed_data["torques"] = self._apply_filters(self.raw_data["torques"], **filters)
        return self.processed_data["torques"]


robot = load_robot(urdf, isFext=False, load_by_urdf=True)
task = UR10(robot, config)
joints = [robot.model.joints[robot.model.getJointId(n)] for n in task.identif_config["active_joints"]]
task.identif_config["act_idxq"] = [joint.idx_q for joint in joints]
task.identif_config["act_idxv"] = [joint.idx_v for joint in joints]
task.identif_config["validation_data_file"] = holdout
task.initialize()
task.solve(decimate=True, decimation_factor=10, plotting=False, wls=method == "wls")

# the fit in the rows of the hold-out
of = task._val_processed_data
full = build_regressor_basic(robot, of["positions"], of["velocities"], of["accelerations"], task.identif_config)
base = build_regressor_reduced(full, task._idx_eliminated)[:, task._base_indices]
effort = (base @ task.phi_base).reshape(6, -1).T
with open(predicted, "w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(["t", *(f"{n}/effort" for n in task.identif_config["active_joints"])])
    writer.writerows(np.column_stack([of["timestamps"], effort]).tolist())
