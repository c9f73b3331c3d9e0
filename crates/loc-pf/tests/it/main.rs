//! Tests of loc-pf, one module per topic.
