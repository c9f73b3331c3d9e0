//! What a bag holds: its topics with their types, numbers and rates.

use super::bag::{Channel, MessageReader, RawMessage};
use super::messages::Stamp;
use crate::Result;

/// The topics of a bag, counted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Survey {
    /// In the order in which they appear in the bag.
    pub topics: Vec<Topic>,
    /// Where the bag breaks off, and what was passed over.
    pub notes: Vec<String>,
}

/// A topic with its messages.
#[derive(Debug, Clone, PartialEq)]
pub struct Topic {
    /// Its name, type and encoding.
    pub channel: Channel,
    /// Number of messages.
    pub count: u64,
    /// Their bytes.
    pub bytes: u64,
    /// When the first and the last of them were recorded.
    pub span: Option<(Stamp, Stamp)>,
}

impl Topic {
    /// Messages a second, of a topic with at least two at different times.
    pub fn rate(&self) -> Option<f64> {
        let (first, last) = self.span?;
        let seconds = last.seconds_since(first);
        (seconds > 0.0 && self.count > 1).then(|| (self.count - 1) as f64 / seconds)
    }
}

impl Survey {
    /// Reads a bag to its end; `look` is shown every message, with its channel.
    ///
    /// # Errors
    /// What the bag reports.
    pub fn of(
        bag: &mut dyn MessageReader,
        look: &mut dyn FnMut(&Channel, &RawMessage<'_>),
        progress: &mut dyn FnMut(f64),
    ) -> Result<Self> {
        let mut survey = Survey::default();
        let (mut count, mut data) = (0_u32, Vec::new());
        loop {
            count = count.wrapping_add(1);
            if count.is_multiple_of(256) {
                progress(bag.progress());
            }
            let Some(message) = bag.next_message()? else { break };
            let (index, log_time) = (message.channel, message.log_time);
            data.clear();
            data.extend_from_slice(message.data);
            survey.add(bag.channels());
            if let Some(topic) = survey.topics.get_mut(index) {
                let message = RawMessage { channel: index, log_time, data: &data };
                topic.take(&message);
                look(&topic.channel, &message);
            }
        }
        survey.add(bag.channels());
        survey.notes = bag.notes();
        Ok(survey)
    }

    /// Adds the channels that are not known yet; any message may bring some.
    fn add(&mut self, channels: &[Channel]) {
        for channel in channels.iter().skip(self.topics.len()) {
            let channel = channel.clone();
            self.topics.push(Topic { channel, count: 0, bytes: 0, span: None });
        }
    }

    /// From the first message to the last.
    pub fn span(&self) -> Option<(Stamp, Stamp)> {
        let spans = || self.topics.iter().filter_map(|topic| topic.span);
        Some((spans().map(|span| span.0).min()?, spans().map(|span| span.1).max()?))
    }

    /// Number of messages.
    pub fn count(&self) -> u64 {
        self.topics.iter().map(|topic| topic.count).sum()
    }
}

impl Topic {
    fn take(&mut self, message: &RawMessage<'_>) {
        let at = Stamp(message.log_time);
        let (first, last) = self.span.unwrap_or((at, at));
        self.span = Some((first.min(at), last.max(at)));
        self.count += 1;
        self.bytes += message.data.len() as u64;
    }
}
