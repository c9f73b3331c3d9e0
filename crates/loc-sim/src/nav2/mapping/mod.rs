//! What each parameter of nav2_amcl is here, by groups. A new setting of the filter is honoured by
//! changing the lines of its parameters in these files.

mod laser;
mod motion;
mod particles;
mod recovery;
mod ros;
mod start;

use super::AmclParameters;
use super::given::Given;
use crate::Result;

pub(super) fn map(mut given: Given) -> Result<AmclParameters> {
    let mut parameters = AmclParameters::default();
    motion::motion(&mut given, &mut parameters.mcl)?;
    particles::particles(&mut given, &mut parameters)?;
    recovery::recovery(&mut given, &mut parameters.mcl)?;
    laser::laser(&mut given, &mut parameters.mcl)?;
    start::start(&mut given, &mut parameters)?;
    ros::ros(&mut given, &mut parameters)?;
    parameters.mcl.validate().map_err(|error| given.error(&error))?;
    parameters.warnings = given.into_warnings();
    Ok(parameters)
}
