//! Tests that need the inside of the method: the printed rules beside the corrected ones, and numerical integration.
