// Times Pinocchio's algorithms on arms that speed.py writes: pinocchio ARM.txt...
//
// Prints `algorithm arm nanoseconds`: the median over windows of 500 calls with states that change.
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace pin = pinocchio;

template <class Call> void time_of(const char *algorithm, const std::string &arm, Call call) {
  const int windows = 101, calls = 500;
  std::vector<double> each;
  for (int window = 0; window < windows; window++) {
    auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < calls; k++) call(k);
    std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
    each.push_back(spent.count() / calls);
  }
  std::nth_element(each.begin(), each.begin() + windows / 2, each.end());
  std::printf("%s %s %.1f\n", algorithm, arm.c_str(), each[windows / 2]);
}

int main(int count, char **paths) {
  for (int p = 1; p < count; p++) {
    std::ifstream file(paths[p]);
    std::string arm;
    int joints;
    file >> arm >> joints;
    pin::Model model;
    for (int j = 0; j < joints; j++) {
      pin::SE3 place;
      Eigen::Vector3d centre;
      Eigen::Matrix3d inertia;
      double mass;
      for (int k = 0; k < 9; k++) file >> place.rotation()(k / 3, k % 3);
      for (int k = 0; k < 3; k++) file >> place.translation()[k];
      file >> mass;
      for (int k = 0; k < 3; k++) file >> centre[k];
      for (int k = 0; k < 9; k++) file >> inertia(k / 3, k % 3);
      auto id = model.addJoint(j, pin::JointModelRZ(), place, "joint" + std::to_string(j));
      model.appendBodyToJoint(id, pin::Inertia(mass, centre, inertia), pin::SE3::Identity());
    }
    pin::Data data(model);
    std::vector<Eigen::VectorXd> q, v, a;
    std::srand(1);
    for (int k = 0; k < 500; k++) {
      q.push_back(Eigen::VectorXd::Random(joints));
      v.push_back(Eigen::VectorXd::Random(joints));
      a.push_back(Eigen::VectorXd::Random(joints));
    }
    volatile double sink = 0;
    time_of("inverse_dynamics", arm, [&](int k) { sink = sink + pin::rnea(model, data, q[k], v[k], a[k])[0]; });
    time_of("inertia_matrix", arm, [&](int k) {
      sink = sink + pin::crba(model, data, q[k], pin::Convention::LOCAL)(0, 0);
    });
    time_of("standard_regressor", arm, [&](int k) {
      sink = sink + pin::computeJointTorqueRegressor(model, data, q[k], v[k], a[k])(0, 0);
    });
  }
}
