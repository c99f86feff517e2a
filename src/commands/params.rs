//! `armident params`.

use armident_ident::MinimalSet;
use armident_report::ParamsReport;

use crate::args::ParamsArgs;
use crate::failure::{Failure, Outcome};
use crate::{output, robot};

pub(crate) fn run(args: &ParamsArgs) -> Result<Outcome, Failure> {
    output::protect([args.robot.as_path()], [args.output.json.as_ref()])?;
    let model = robot::load(&args.robot, &args.chain, None)?;
    let set = MinimalSet::of(&model.rigid_arm())?;
    let report = ParamsReport::new(&model, &set);
    output::say_all(&args.output, "note", &robot::notes(&model));
    output::write_result(&args.output, &report.text(), &report, report.warnings())
}
