//! Foreign text with several sensors of one kind, or one sensor in several files.

use crate::mapped::mapped;

#[test]
fn a_counter_is_no_time_where_another_column_is() {
    let row = |k: u32| format!("{k},{},0.01,0.02,-9.81,1e-4,2e-4,{}e-4\n", k * 100, k % 7);
    let rows: String = (0..1000).map(row).collect();
    let names = "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z";
    let (report, mapping, dataset) = mapped(&[("mt.txt", format!("{names}\n{rows}"))]);
    let length_s = dataset.imu[999].time - dataset.imu[0].time;
    assert!((length_s - 9.99).abs() < 1e-9, "{length_s} {report}\n{mapping}");
}

#[test]
fn ticks_of_100_ns_are_converted_to_utc() {
    for (epoch, unit) in
        [(116_444_736_000_000_000_u64, "filetime"), (621_355_968_000_000_000, "ticks")]
    {
        let row = |k: u64| {
            let ticks = epoch + 17_149_032_000_000_000 + k * 400_000;
            format!("{ticks},0.01,0.02,-9.81,1e-4,2e-4,{}e-4\n", k % 7)
        };
        let rows: String = (0..1000).map(row).collect();
        let text = format!("time,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n{rows}");
        let (report, mapping, dataset) = mapped(&[("imu.csv", text)]);
        assert!(mapping.contains(&format!("unit = \"{unit}\"")), "{report}");
        assert_eq!(dataset.imu[25].time.seconds(), 1_714_903_201.0, "{report}");
    }
}
