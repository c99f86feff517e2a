"""Fields of the results, made by `python/tests/fields.py` from the schemas of the library."""

from typing import Any, Literal

from ._results import Fields

class IdentifyReport:
    """Result of `armident identify`."""

    condition: float
    """Condition number of the normalised columns (of the worst step of Algorithm 2)."""
    consistency: ConsistencyReport | None
    """Physically consistent links of the model; `null` with `--raw-estimate`."""
    constants: list[ConstantRow]
    """Constants of the minimal set."""
    cross_validation: FitRows | None
    """Errors on each recording of a fit to the others, with `--cross-validate` and several recordings."""
    cutoff_hz: float | None
    """Cut-off frequency of the low-pass [Hz]; `null` where recorded accelerations were used."""
    drive_gains: list[DriveGainRow]
    """Gains of drives whose current was recorded instead of an effort; absent without any."""
    effective_sample_share: float
    """Effective sample size over samples after filtering."""
    effects: list[EffectRow]
    """Parameters of effects on joints."""
    effort_noise: dict[str, float | None]
    """Residual level of the low-passed effort, by joint [N m or N]."""
    endogeneity: EndogeneityRow | None
    """Durbin-Wu-Hausman test, with `iv`."""
    estimator: str | None
    """Estimator: `ols`, `wls`, `irls` or `iv`; `null` with Algorithm 2."""
    fit: FitReport
    """Effort errors of the model (with `--raw-estimate` of the estimate) and of the URDF. One and a half periods of the cut-off frequency are left out at both ends of a recording."""
    holdout_recordings: list[str]
    """Hold-out recordings."""
    joints: list[str]
    """Chain joints in order."""
    merged: list[MergedRow]
    """Parameters that are not separately identifiable on this arm."""
    method: str
    """`algorithm2` or `batch`."""
    not_significant: list[str]
    """Parameters whose 95 % interval includes 0."""
    parameters: int
    """Number of parameters."""
    payloads: list[PayloadRow]
    """Known payloads of recordings; absent without `--payload`."""
    prior_scale: float | None
    """Prior scale: relative standard deviation of the URDF inertias; `null` without a prior."""
    rank: int
    """Numerical rank."""
    recordings: list[str]
    """Training recordings."""
    robot: str
    """Robot name."""
    rows: int
    """Rows of the least-squares problem."""
    schema: str
    """`armident.identify/2`."""
    sensed_gears: list[SensedGearRow]
    """What lies between motor and torque sensor, of joints with a current and an effort; absent without any."""
    steps: list[StepRow]
    """Steps of Algorithm 2; empty for `batch`."""
    velocities: str
    """Source of the velocities: `position` or `recorded`."""

class CheckReport:
    """Result of `armident check`."""

    channels: list[ChannelRow]
    """What each effort column is."""
    checks: list[CheckRow]
    """The checks, those of the arm first."""
    constants: list[ConstantCheckRow]
    """Constants of the minimal set."""
    cutoff_hz: float | None
    """Cut-off frequency of the low-pass [Hz]; `null` where recorded accelerations were used."""
    joints: list[str]
    """Chain joints in order."""
    parameters: int
    """Number of parameters."""
    quality: list[Any]
    """Measurements without a model, per recording: `timing`, `channels` (range, `noise`, `step`, `band_edge_hz`, shares), `findings`."""
    rank: int
    """Rank of the recordings alone."""
    recordings: list[str]
    """Recordings checked."""
    robot: str
    """Robot name."""
    schema: str
    """`armident.check/2`."""
    verdict: CheckVerdict
    """The worst of the verdicts."""

class DiagnoseReport:
    """Result of `armident diagnose`."""

    comparison_bandwidth_hz: ComparisonBandwidth
    constants: MinimalSetEstimate
    coulomb_regularised_below: RegularisedCoulomb
    effort_clock: ClockOfEfforts
    effort_low_pass: LowPassedEfforts
    effort_noise: dict[str, float | None]
    """Standard deviation of one recorded effort sample, by joint [N m or N]."""
    findings: list[FindingRow]
    """Missing effects, most material first."""
    fit: Fits
    """Effort errors."""
    holdout_recordings: list[str]
    """Hold-out recordings."""
    inconclusive_changes: InconclusiveChanges
    input_checks: InputCheckRows
    """Outcome of the input checks."""
    joints: list[str]
    """Chain joints in order."""
    link_errors_material_on: list[str]
    """Joints on which the errors of all link inertias together are material."""
    next_motion: NextMotionResult
    placebo: PlaceboTest
    placeholder_links: PlaceholderLinks
    position_fit: PositionFit
    presliding_travel: Presliding
    prior_scale: float
    """Relative standard deviation of the given model's inertias that makes the recordings most likely."""
    prismatic_joints: list[str] | None
    """Joints that translate: their positions are in m and their efforts in N, all others in rad and N m. `null` where that is not known."""
    projection_standard_errors: Projection
    recordings: list[str]
    """Training recordings."""
    reference_max_speed: ReferenceSpeed
    reference_recordings: list[str]
    """Recordings of the reference; absent without `--reference`."""
    replay: ReplayPair
    residual_map: list[JointResiduals]
    """Residuals by joint, and what they depend on."""
    robot: str
    """Robot name."""
    schema: str
    """`armident.diagnosis/2`."""
    sentence: str
    """First line of the text."""
    small_terms: SmallTerms
    sublinear_viscous: SublinearViscous
    transmissions: Transmissions
    unexplained: list[str]
    """Joints whose residual, with all findings, is over three times the in-band noise."""
    verdict: str
    """`match`, or `mismatch`: findings, failed input checks, or joints in `unexplained` or `link_errors_material_on`."""
    whiteness_p: dict[str, float | None]
    """p-value of the Ljung-Box test of the hold-out residual, by joint; `null` where it is too short."""
    worse_on_holdout: list[str]
    """Joints whose hold-out error is over 10 % larger than with the given model."""

class ValidateReport:
    """Result of `armident validate`."""

    after: dict[str, EffortErrorRow]
    """Effort error of the model, by joint."""
    before: dict[str, EffortErrorRow]
    """Effort error of the URDF's links without effects, by joint."""
    cutoff_hz: float | None
    """Cut-off frequency of the low-pass [Hz]."""
    joints: list[str]
    """Chain joints in order."""
    model: str
    """Model file or URDF."""
    positions: PositionsUnderCommands | None
    """Position errors under commands; `null` where efforts are recorded."""
    prismatic_joints: list[str] | None
    """Joints that translate: their positions are in m and their efforts in N, all others in rad and N m. `null` where that is not known."""
    recordings: list[str]
    """Hold-out recordings."""
    replay_after: ReplayReport | None
    """Forward replay of the model, likewise."""
    replay_before: ReplayReport | None
    """Forward replay of the URDF; `null` where it cannot be simulated, and with `--no-replay`."""
    robot: str
    """Robot name."""
    schema: str
    """`armident.validate/1`."""

class FleetReport:
    """Result of `armident fleet`."""

    cutoff_hz: float
    """Cut-off of the low-pass [Hz]."""
    false_alarm_rate: float
    """Probability of a change of a robot that does not change."""
    outliers: list[FleetOutlierRow]
    """Parameters of robots that are unlike the fleet's."""
    parameters: list[FleetParameter]
    """Parameters of the arm."""
    robot: str
    """Name of the arm in its URDF."""
    robots: list[FleetRobot]
    """The robots."""
    scatter_freedom: float
    """Degrees of freedom of the scatter of recordings."""
    scatter_recordings: int
    """Recordings that the scatter was estimated from."""
    schema: str
    """`armident.fleet/1`."""
    set_aside: list[SetAside]
    """Files and states that are not part of it."""

class AlternativeRow(Fields):
    """An effect that the recordings cannot distinguish from a finding."""

    effect: str
    """Slug of the effect."""
    extra_residual: float | None
    """Additional root mean square residual with it instead of the finding, in noise levels."""
    joints: list[str]
    """Its joints."""
    link: str | None
    """Its link, or `null`."""
    separated_by: str | None
    """How to distinguish the two; `null` where the library knows no motion."""

class ChannelRow(Fields):
    """What one effort column is."""

    column: str
    """Joint whose column most likely holds this joint's effort."""
    gain: float
    """Most likely gain, recorded over joint effort."""
    gain_95: list[float | None]
    """Its 95 % interval."""
    joint: str
    """The joint."""
    probability: dict[str, float]
    """Probability of `joint_effort`, `sign_flipped`, `other_gain`, `other_gain_flipped` and `without_gravity`."""
    residual_rms: float
    """Root mean square residual of a free fit to the column."""
    sd: float
    """Standard deviation of the column."""
    urdf_sd: float
    """Standard deviation of the URDF's effort on this motion [N m or N]."""

class CharacterRow(Fields):
    """Kind of residual structure that no law explains."""

    drift_share: float
    """Share explained by time."""
    kind: str
    """`dissipative` (work is lost in both directions), `conservative` (work is returned), or `neither`."""
    memory_share: float
    """Share explained by time or travel since the last reversal."""
    wave: list[float]
    """Cycles a turn (a metre) of the strongest wave in the position, and the share that it explains."""
    work_share: float
    """Work lost over all work exchanged, -1 to 1."""

class CheckRow(Fields):
    """One check with its verdict."""

    advice: str | None
    """What to do."""
    interval_95: list[float] | None
    """95 % interval of the number; `null` where there is none."""
    joint: str | None
    """The joint; `null` for the arm as a whole."""
    message: str
    """One sentence."""
    topic: CheckTopic
    """What was checked."""
    unit: str
    """Unit of the number."""
    value: float | None
    """The number behind the verdict; `null` where there is none."""
    verdict: CheckVerdict
    """The verdict."""

CheckTopic = Literal["rate"] | Literal["noise"] | Literal["channel"] | Literal["order"] | Literal["gravity"] | Literal["joint_sign"] | Literal["geometry"] | Literal["delay"] | Literal["clock"] | Literal["excitation"] | Literal["quality"] | Literal["command"]

CheckVerdict = Literal["ok"] | Literal["cannot_tell"] | Literal["doubtful"] | Literal["wrong"]

class ClockOfEfforts(Fields):
    """Clock of all recorded efforts against that of the positions: its drift is undone before the fit, and predictions have it."""

    drift: float
    """By which share it is fast: what is recorded after `t` seconds was measured `drift t` later."""
    interval_95: list[float]
    """95 % interval of the drift."""

ComparisonBandwidth = float

class ConsistencyReport(Fields):
    """Physically consistent links, and effects of admissible sign, of a model."""

    bound_holds_to: float
    """Size of the links, relative to the URDF's, up to which the bound holds."""
    converged: bool
    """Whether the iteration has converged; if not, the bound still holds."""
    distance_at_least: float
    """Lower bound of the distance of any consistent links up to `bound_holds_to` times the size of the URDF's."""
    distance_in_standard_errors: float
    """Distance from the estimate in its own information metric [standard errors]."""
    divergence_from_urdf: float
    """Entropic divergence of the links from the URDF's."""
    duality_gap: float
    """Duality gap of half the squared distance."""
    exact: bool
    """Whether the estimate is physically consistent."""
    links: dict[str, list[float]]
    """Ten parameters of every link about the origin of its frame `E_i`, by joint."""
    smallest_eigenvalues: dict[str, float | None]
    """Smallest eigenvalue of every link's pseudo-inertia, by joint."""
    steps: int
    """Newton steps."""
    urdf_links_projected: list[str]
    """Joints whose URDF link is not physically consistent: the nearest consistent one was used instead."""
    urdf_links_thickened: list[str]
    """Joints whose URDF link has no mass or no extent: a tiny one was used instead."""

class ConstantCheckRow(Fields):
    """How well the recordings alone determine one constant."""

    joint: str
    """Joint name."""
    label: str
    """Label of the paper."""
    reason: str | None
    """Why the constant is poorly determined."""
    size: float
    """Size by the URDF: the sum over all links, each off by its own size."""
    standard_error: float | None
    """Standard error from the recordings alone; `null` where they do not determine the constant."""
    unit: str
    """Unit."""
    verdict: CheckVerdict
    """`ok` up to a tenth of the size, `doubtful` up to the size, `cannot_tell` beyond."""

class ConstantRow(Fields):
    """One constant of the minimal set."""

    consistent: float | None
    """Value of the model's physically consistent links; absent without a projection."""
    interval_95: list[float] | None
    """95 % interval."""
    joint: str
    """Joint name."""
    label: str
    """Label of the paper."""
    prior_share: float
    """Prior share of the information, 0 to 1."""
    standard_error: float | None
    """Standard error."""
    undetermined: float
    """Share of the constant that the recordings do not identify, 0 to 1."""
    unit: str
    """Unit."""
    urdf: float
    """Value of the URDF."""
    value: float | None
    """Estimate; `null` when no step determined it."""

class DriveGainOfMasses(Fields):
    """Gain of a joint whose effort is recorded as a current or voltage."""

    determined: bool
    """Whether the recordings identify it (an interval of less than a factor of ten); if not, the joint is excluded."""
    gain: float
    """Effort per unit [N m or N, per A or V], inferred from the URDF masses."""
    interval_95: list[float | None]
    """Its 95 % interval."""
    joint: str
    """Joint."""
    of_model: bool
    """Whether it comes from the given model, identified with a known load; else from the URDF masses."""
    quantity: str
    """`current` or `voltage`."""

class DriveGainRow(Fields):
    """Gain of a drive: effort per unit current."""

    interval_95: list[float] | None
    """95 % interval; `null` where the gain is not identifiable."""
    joint: str
    """Joint name."""
    standard_error: float | None
    """Standard error; `null` for the drive that the others are relative to."""
    unit: str
    """`N m/A`, `N/A` or `relative`."""
    used: float
    """Gain used in the fit."""
    value: float
    """Estimate; relative to one drive where only ratios are identifiable."""

class EffectRow(Fields):
    """One parameter of an effect on a joint."""

    admissible: bool
    """Whether the law admits the sign."""
    at_bound: bool
    """Whether the estimate is at its bound, 0."""
    effect: str
    """Slug of the effect."""
    joint: str
    """Joint name."""
    other_joint: str | None
    """Second of two joints that share a transmission; else absent."""
    parameter: str
    """Parameter of the law."""
    standard_error: float | None
    """Standard error; `null` at the bound."""
    undetermined: float
    """Share that the recordings do not identify, 0 to 1."""
    unit: str
    """Unit."""
    value: float
    """Estimate."""

class EffortErrorRow(Fields):
    """Effort error of one joint; `null` where a number could not be determined."""

    band_coverage: float | None
    """Share of samples in the 95 % band: 1.96 noise levels of the fit."""
    lag1_correlation: float | None
    """Lag-1 autocorrelation of the residual."""
    relative: float
    """Relative to the standard deviation of the effort."""
    rmse: float
    """Root mean square, low-passed [N m or N]."""
    rmse_raw: float
    """Root mean square, unfiltered [N m or N]."""
    whiteness_p: float | None
    """p-value of the Ljung-Box test over 10 lags, residual thinned to twice the cut-off frequency."""

class EffortErrors(Fields):
    """Root mean square effort errors, unfiltered, by joint [N m or N]."""

    after: dict[str, float | None]
    """Diagnosed model."""
    before: dict[str, float | None]
    """Given model, without effects."""
    rigid: dict[str, float | None]
    """Links-only fit."""

class EndogeneityRow(Fields):
    """Durbin-Wu-Hausman test of endogeneity."""

    p: float
    """p-value over all parameters."""
    t: float
    """Shift between least squares and instrumental variables, in standard errors."""
    term: str
    """Parameter with the largest shift."""

class ErrorWithoutLaw(Fields):
    """Position error of a joint without a law, all others fitted again, over that with it. Errors count by their logarithm where they are large, as in the fit."""

    holdout: float | None
    """On the hold-out; `null` without one."""
    joint: str
    """Joint."""
    law: str
    """`sag` (weight that no controller carries), `sag_and_offset` (both), `delay`, `damping`, `lag` (both), `dry_friction`, `static_friction`, `load_friction`, `offset` or `inertia`."""
    train: float
    """On the training recordings."""

class EstimateRow(Fields):
    """A parameter with its standard error."""

    stderr: float | None
    """Standard error; `null` where it is not known."""
    unit: str
    """Unit; `1` of a pure number."""
    value: float
    """Estimate."""

class EvidenceRow(Fields):
    """Evidence of a finding."""

    character: CharacterRow | None
    """Of `unmodelled`: kind of structure."""
    holdout_gain: float | None
    """Share of the squared error of the hold-out on `joint` that the finding removes, all else refitted; negative where the error is higher with it. Absent without a hold-out, for contacts, and for arms without efforts."""
    joint: str
    """The joint on which it is most material."""
    materiality: float
    """Root mean square effort that only this finding explains, all else refitted, in noise levels (`effort_noise`) of `joint`."""
    materiality_threshold: float
    """Least materiality to be reported there."""
    variables: list[str]
    """Of `unmodelled`: columns that the structure depends on."""

class FindingRow(Fields):
    """One effect that is missing from the model."""

    alternatives: list[AlternativeRow]
    """Effects that the recordings cannot distinguish from it."""
    confidence: float
    """A score: 0.50 at the threshold of materiality or size, 0.95 at twice the threshold; less with rivals."""
    confirmed: bool | None
    """Whether the hold-out error is lower with the finding than without it, all else refitted; `null` without a hold-out, and for contacts."""
    effect: str
    """Slug of the effect (as in `simulate --effect`), or `unmodelled`: structure that no law of the library explains."""
    evidence: EvidenceRow
    """Evidence."""
    joints: list[str]
    """One joint; two for `joint_coupling`; none for effects of the whole arm (`gravity_direction`, `time_delay`)."""
    link: str | None
    """Link of `payload` and `link_inertia_error`, else `null`."""
    parameters: dict[str, EstimateRow]
    """Parameters of the law, those that the motion does not excite left out."""
    recording: str | None
    """Of `external_contact`: the recording (file without its extension), else `null`."""
    window: list[float] | None
    """Of `external_contact`: begin and end in its recording [s], else `null`."""

class FitReport(Fields):
    """Effort errors of training, hold-out and URDF."""

    holdout: FitRows | None
    """On the hold-out; absent without one."""
    train: FitRows
    """On the training recordings."""
    urdf: FitRows
    """Of the URDF, without friction, on the hold-out (or else on training)."""

class FitRows(Fields):
    """Effort errors by joint, low-passed."""

    relative: dict[str, float | None]
    """Relative to the standard deviation of the effort."""
    rmse: dict[str, float | None]
    """Root mean square residual [N m or N]."""

class Fits(Fields):
    """Effort errors of training and hold-out."""

    holdout: EffortErrors | None
    """Of the hold-out; `null` without `--holdout`."""
    train: EffortErrors | None
    """Of the training recordings."""

class FleetChangeRow(Fields):
    """A change of a robot."""

    alternatives: list[str]
    """Other parts that explain the recordings as well."""
    between: list[int]
    """First and last number that it may have, by likelihood."""
    degrees_of_freedom: int
    """Its degrees of freedom."""
    false_alarm_probability: float
    """Probability of as large a statistic on a robot that does not change, at most."""
    joint: str
    """The joint that has it, or that moves the link that has it."""
    link: str | None
    """The link, of a body."""
    number: int
    """Its number, from 1, in the order of the robot's recordings."""
    parameter: str | None
    """Label of the parameter that it moves by most standard errors."""
    recording: str
    """First recording with it."""
    sentence: str
    """All that in a sentence."""
    sizes: list[FleetSize]
    """By how much."""
    statistic: float
    """Likelihood ratio over its degrees of freedom."""
    threshold: float
    """What it exceeds."""
    what: str
    """`viscous friction`, `body`."""

class FleetOutlierRow(Fields):
    """A parameter of a robot that is unlike the fleet's."""

    false_alarm_probability: float
    """Probability of as large a difference of a robot of the fleet, at most."""
    median: float
    """Median of the fleet."""
    parameter: str
    """Label of the parameter."""
    robot: str
    """The robot."""
    standard_error: float
    """Standard error of the difference."""
    unit: str
    """Its unit."""
    value: float
    """Its value."""

class FleetParameter(Fields):
    """A parameter of the arm."""

    is_constant: bool
    """Whether it is a constant of the minimal set."""
    label: str
    """Its label."""
    scatter: float
    """Standard deviation between recordings of a robot that does not change."""
    unit: str
    """Its unit."""

class FleetRobot(Fields):
    """A robot over its recordings."""

    changes: list[FleetChangeRow]
    """Its changes."""
    pages: list[str | None]
    """The page of a single diagnosis that stands beside each recording."""
    recorded_at_s: list[float] | None
    """When each was made, since 1970 [s], where all have it."""
    recordings: list[str]
    """Its recordings in their order."""
    robot: str
    """Its name."""
    trends: list[FleetTrend]
    """One of each parameter."""

class FleetSize(Fields):
    """A number of a change, after it less before it."""

    interval: list[float]
    """95 % interval."""
    parameter: str
    """Its name."""
    standard_error: float
    """Its standard error, with the scatter of recordings."""
    unit: str
    """Its unit."""
    value: float
    """Its value."""

class FleetTrend(Fields):
    """A parameter over the recordings of a robot."""

    drift: list[float] | None
    """Drift per recording beside the changes, and its standard error."""
    points: list[list[float] | None]
    """Value and standard error of each recording; none of those that do not determine it."""
    standard_error: float | None
    """Standard error of that."""
    value: float | None
    """Its value before the first change; none where the recordings do not determine it."""

class InconclusiveChange(Fields):
    """A change that is not certain enough to be reported."""

    effect: str
    """Slug of the effect."""
    joints: list[str]
    """Its joints, base to tip; empty for the whole arm."""
    link: str | None
    """Its link, or `null`."""
    maybe_in_reference: bool
    """Whether it is inconclusive because the reference does not rule out that it was already present."""
    p_value: float
    """p-value of the change."""

InconclusiveChanges = list[InconclusiveChange]

class InputCheckRows(Fields):
    """Outcome of the input checks."""

    drive_gains: list[DriveGainOfMasses]
    """Gains of joints with a current or voltage only."""
    faults: list[CheckRow]
    """Checks that failed; their joints are excluded from the diagnosis."""
    unchecked: str | None
    """Why the columns were not checked; `null` where they were."""

class JointResiduals(Fields):
    """Residuals of one joint on the training recordings, below the comparison bandwidth."""

    after: float
    """Root mean square residual of the diagnosed model [N m or N]."""
    before: float
    """Root mean square residual of the given model [N m or N]."""
    joint: str
    """Joint."""
    noise: float
    """Noise [N m or N]."""
    regressors: list[Regressor]
    """Functions of the motion, strongest first."""
    rigid: float
    """Root mean square residual of the links-only fit [N m or N]."""
    variables: list[VariableShare]
    """Variables, strongest first."""
    whiteness_p: float
    """p-value of the Ljung-Box test of the diagnosed model's residual; `null` where it could not be determined."""

class LowPassedEfforts(Fields):
    """Low-pass of first order of all recorded efforts: it is undone before the fit, and predictions go through it."""

    cutoff_hz: float
    """Cut-off [Hz]."""
    interval_95_s: list[float]
    """95 % interval of the time constant [s]."""
    time_constant_s: float
    """Time constant [s]."""

class MergedRow(Fields):
    """A parameter that is not separately identifiable on this arm."""

    into: dict[str, float]
    """Parameters that include it, with factors."""
    term: str
    """The parameter."""

MinimalSetEstimate = list[ConstantRow]

class NextMotionResult(Fields):
    """The motion that best separates the findings from their alternatives. With `--next-motion`."""

    description: str | None
    """The motion in words, or `null`."""
    file: str | None
    """File of the motion; `null` where no motion separates anything."""
    pairs: int
    """Pairs of a finding and an alternative."""
    reason: str | None
    """Why no motion could be designed, or `null`."""
    separated: int
    """Pairs that it separates."""
    separation: float | None
    """Median over the pairs of what the alternative and all that is fitted anyway do not imitate, in standard errors; `null` without a motion."""

class PayloadRow(Fields):
    """A payload of known mass on the last link."""

    centre_of_mass_m: list[float]
    """Its centre of mass in the frame of the last moving link [m]."""
    is_estimated: bool
    """Whether the centre of mass was estimated."""
    mass_kg: float
    """Its mass [kg]."""
    recordings: list[str]
    """Recordings that have it."""

class PlaceboTest(Fields):
    """Result of the placebo test: what the selection makes of terms that are known to be wrong. With `--placebo`."""

    improving: int
    """Terms that lower the cross-validated error by more than its standard error."""
    largest_over_threshold: float
    """Materiality of the largest term over the materiality threshold."""
    reported: int
    """Terms that would be reported."""
    terms: int
    """Wrong terms tried."""

PlaceholderLinks = list[str]

class PositionErrors(Fields):
    """Root mean square position errors over all recordings of a kind, by joint [rad or m]."""

    after: dict[str, float | None]
    """Simulated from the commands by the diagnosed model."""
    before: dict[str, float | None]
    """Command minus position."""

class PositionFit(Fields):
    """How positions follow from commands. With commands instead of efforts."""

    currents_without_sign: list[str]
    """Joints whose recorded current is a magnitude."""
    holdout: PositionErrors | None
    """Of the hold-out; `null` without `--holdout`."""
    stiffness_not_determined: list[str]
    """Joints whose stiffness no motion determines: their friction is known over it."""
    train: PositionErrors
    """Of the training recordings."""
    without: list[ErrorWithoutLaw]
    """What each law is worth."""

class PositionsUnderCommands(Fields):
    """RMS position errors of an arm behind its controllers [rad or m]."""

    command: dict[str, float | None]
    """Of the command itself."""
    diverged: int
    """Windows that diverged."""
    in_windows: dict[str, float | None]
    """Of the model, from the recorded state at the start of each window on."""
    whole: dict[str, float | None]
    """Of the model, from the first sample of each recording on."""
    window_s: float
    """Length of a window [s]."""
    windows: int
    """Windows simulated to their end."""

Presliding = dict[str, float | None]

Projection = float

ReferenceSpeed = dict[str, float | None]

class Regressor(Fields):
    """A function of the motion and the share of the residual variance that it explains alone."""

    function: str
    """The function."""
    indicates: str
    """Effects that a large share indicates."""
    share_after: float
    """Share explained with the diagnosed model."""
    share_before: float
    """Share explained with the given model."""

class RegressorBin(Fields):
    """Samples of one bin of a variable."""

    # 'from'
    """Lower end of the variable."""
    mean_after: float
    """Mean residual of the diagnosed model [N m or N]."""
    mean_before: float
    """Mean residual of the given model [N m or N]."""
    rms_after: float
    """Root mean square residual of the diagnosed model [N m or N]."""
    rms_before: float
    """Root mean square residual of the given model [N m or N]."""
    rows: int
    """Samples."""
    to: float
    """Upper end."""

RegularisedCoulomb = dict[str, float | None]

class ReplayPair(Fields):
    """Root mean square position error after recorded efforts drove the simulated arm over short windows of the hold-out, by joint [rad or m]."""

    after: dict[str, float | None]
    """With the diagnosed model."""
    before: dict[str, float | None]
    """With the given model."""
    window_s: float
    """Length of a window [s]."""

class ReplayReport(Fields):
    """Forward replay of all joints."""

    diverged: int
    """Windows that diverged."""
    position_rms: dict[str, float | None]
    """Root mean square position error [rad or m]."""
    velocity_rms: dict[str, float | None]
    """Root mean square velocity error [rad/s or m/s]."""
    window_s: float
    """Length of a window [s]."""
    windows: int
    """Windows simulated to their end."""

class SensedGearRow(Fields):
    """Between the motor of a joint and its torque sensor."""

    coulomb: SensedNumber
    """Coulomb friction [N m or N]."""
    determined: bool
    """Whether the effort of the sensor determines the gain; if not, the numbers mean nothing."""
    gain: SensedNumber
    """Torque constant times gear ratio [N m/A or N/A]."""
    inertia: SensedNumber
    """Inertia of motor and gear [kg m2 or kg]."""
    joint: str
    """Joint name."""
    offset: SensedNumber
    """Effort of the sensor at a current of 0, with the other sign [N m or N]."""
    rms: float
    """RMS residual in terms of effort [N m or N]."""
    viscous: SensedNumber
    """Viscous friction [N m s/rad or N s/m]."""

class SensedNumber(Fields):
    """A number with its standard error."""

    standard_error: float
    """Its standard error."""
    value: float
    """The estimate."""

class SetAside(Fields):
    """A file that is not part of the result."""

    file: str
    """The file or recording."""
    reason: str
    """Why."""

class SmallTerm(Fields):
    """A term of the model that no finding stands for."""

    effect: str
    """Slug of the effect."""
    joint: str
    """Joint."""
    parameters: dict[str, SmallTermParameter]
    """Parameters of the law."""

class SmallTermParameter(Fields):
    """A parameter of a small term."""

    unit: str
    """Unit."""
    value: float
    """Value."""

SmallTerms = list[SmallTerm]

class StepRow(Fields):
    """One step of Algorithm 2."""

    columns: int
    """Columns."""
    condition: float
    """Condition number."""
    equation: str
    """Equation of the paper."""
    observed: str
    """Observed joint."""
    rank: int
    """Rank over columns."""
    rmse: float
    """Residual RMS."""
    rows: int
    """Rows."""
    step: str
    """Number in the paper."""
    unknowns: list[str]
    """Constants estimated."""

SublinearViscous = dict[str, float | None]

class TransmissionRow(Fields):
    """A transmission between motor and link."""

    damping: float
    """Damping [N m s/rad or N s/m]."""
    gap: float
    """Gap [rad or m]; 0 without backlash."""
    joint: str
    """Joint."""
    motor_inertia: float
    """Motor inertia beyond that of the given model [kg m2 or kg]."""
    share: float
    """Fitted share of the difference to a rigid transmission; 1 where the law holds."""
    stiffness: float
    """Stiffness, of the flanks where there is a gap [N m/rad or N/m]."""

Transmissions = list[TransmissionRow]

class VariableShare(Fields):
    """A variable and the share of the residual variance that the means of its bins explain."""

    bins: list[RegressorBin]
    """Bins of about as many samples each; of `time`, of equal length."""
    share_after: float
    """Share explained with the diagnosed model."""
    share_before: float
    """Share explained with the given model, beyond that of random bins."""
    variable: str
    """`speed`, `direction`, `load`, `position`, `acceleration`, `time_since_reversal`, `travel_since_reversal` or `time`."""
