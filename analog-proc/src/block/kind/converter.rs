//! `adc`, `dac`, `mdac`, `dcu`: analog values to and from the digital side.

use super::*;

kind! {
    Adc(f) { channel: u32 = f.channel("channel", ChannelKind::Adc, 1) }
    "adc", "Σ, sampled for the digital side", "`channel` 0–63; `max` full scale",
    r#"in = ["a"], channel = 0, max = 10.0"#, class: Some(BlockClass::AdcChannel),
}

impl Component for Adc {
    fn claim(&self) -> Option<Claim> {
        Claim::one(ChannelKind::Adc, self.channel, 0.0)
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.flag(&format!("ADC {}", self.channel));
    }
}

kind! {
    Dac(f) {
        channel: u32 = f.channel("channel", ChannelKind::Dac, 1),
        initial: f64 = f.number("initial", Some(0.0)),
    }
    "dac", "the value that the digital side sends",
    "`channel` 0–63; `initial` (0); `max` full scale", "channel = 0, max = 10.0",
    inputs: Inputs::exactly(0), class: Some(BlockClass::Dac), size: (52.0, 26.0),
}

impl Component for Dac {
    fn claim(&self) -> Option<Claim> {
        Claim::one(ChannelKind::Dac, self.channel, self.initial)
    }

    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        let hold = held(&mut to.m.dac_channels, self.channel, self.initial);
        to.push(Op::Dac { o, hold }, &[o], true);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.flag(&format!("DAC {}", self.channel));
    }
}

kind! {
    Mdac(f) {
        channel: u32 = f.channel("channel", ChannelKind::Dac, 1),
        initial: f64 = f.number("initial", Some(0.0)),
    }
    "mdac", "Σ times the value sent", "as `dac`, on the same channels",
    r#"in = ["a"], channel = 1"#, class: Some(BlockClass::Mdac),
}

impl Component for Mdac {
    fn claim(&self) -> Option<Claim> {
        Claim::one(ChannelKind::Dac, self.channel, self.initial)
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let u = to.sum(&block.inputs);
        let hold = held(&mut to.m.dac_channels, self.channel, self.initial);
        to.push(Op::Mdac { o, hold, a: u.slot, c: u.c }, &[o], true);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.text(0.0, -2.0, "tiny", "MDAC");
        pen.text(0.0, 12.0, "tiny", &self.channel.to_string());
    }
}

kind! {
    Dcu(f) {
        channel: u32 = f.channel("channel", ChannelKind::Dcu, 1),
        initial: f64 = f.number("initial", Some(0.0)),
        // Left out, it is the profile's.
        range: Option<f64> = f.positive("range", Some(f64::INFINITY))
            .map(|range| Some(range).filter(|r| r.is_finite())),
    }
    "dcu", "Σ times a coefficient sent",
    "`channel` 0–127; `initial` (0); `range`: largest coefficient it is scaled for (default the machine's)",
    r#"in = ["a"], channel = 0, range = 5"#, class: Some(BlockClass::Dcu), size: (34.0, 34.0),
}

impl Component for Dcu {
    fn claim(&self) -> Option<Claim> {
        let claim = Claim::one(ChannelKind::Dcu, self.channel, self.initial)?;
        Some(Claim { range: self.range, ..claim })
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let dcu = held(&mut to.m.dcu_channels, self.channel, self.initial);
        to.through(o, block, |Term { slot: a, c }| Op::Dcu { o, dcu, a, c });
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.circle(0.0, 1.0);
        pen.text(0.0, -1.0, "tiny", "DCU");
        pen.text(0.0, 10.0, "tiny", &self.channel.to_string());
    }
}

/// The place of a channel among those of its sort.
fn held(channels: &mut Vec<(u32, f64)>, channel: u32, initial: f64) -> u32 {
    let known = channels.iter().position(|c| c.0 == channel);
    known.unwrap_or_else(|| {
        channels.push((channel, initial));
        channels.len() - 1
    }) as u32
}
