
/* speeds with a threshold of the residual, and these */
static const int ARM_SPEEDS[ARM_JOINTS] = { {{speeds}} };
static const double ARM_SPEED[ARM_JOINTS][{{columns}}] = {
{{speed}}};
static const double ARM_THRESHOLD[ARM_JOINTS][{{columns}}] = {
{{threshold}}};

void arm_thresholds(const double dq[ARM_JOINTS], double threshold[ARM_JOINTS]) {
  int i;
  for (i = 0; i < ARM_JOINTS; i++) {
    const double speed = fabs(dq[i]);
    const double *at = ARM_SPEED[i], *of = ARM_THRESHOLD[i];
    const int last = ARM_SPEEDS[i] - 1;
    int k = 0;
    while (k <= last && at[k] < speed) k++;
    if (k == 0) threshold[i] = of[0];
    else if (k > last) threshold[i] = of[last];
    else threshold[i] = of[k - 1] + (speed - at[k - 1]) / (at[k] - at[k - 1]) * (of[k] - of[k - 1]);
  }
}

int arm_alarm(const arm_observer *observer, const double dq[ARM_JOINTS]) {
  double threshold[ARM_JOINTS], largest = 1.0;
  int i, joint = -1;
  arm_thresholds(dq, threshold);
  for (i = 0; i < ARM_JOINTS; i++) {
    const double ratio = fabs(observer->residual[i]) / threshold[i];
    if (ratio > largest) {
      largest = ratio;
      joint = i;
    }
  }
  return joint;
}
