
/* Gain of the observer [1/s] that the thresholds are for; they hold at about {{rate_hz}} Hz. */
#define ARM_OBSERVER_GAIN {{gain}}

/* Thresholds of the residual at a velocity, for {{per_hour}} false alarms per hour of the whole arm: linear between speeds of the
 * recordings, constant beyond them. */
void arm_thresholds(const double dq[ARM_JOINTS], double threshold[ARM_JOINTS]);

/* The joint whose residual is above its threshold, relatively most; -1 where none is. */
int arm_alarm(const arm_observer *observer, const double dq[ARM_JOINTS]);
